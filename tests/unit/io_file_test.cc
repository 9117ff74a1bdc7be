// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <iterator>
#include <limits>
#include <string>
#include <thread>

#include "fransac/io/file.hpp"
#include "temporary_folder.h"

namespace fransac::io {
namespace {

using fransac::testing::read_text;
using fransac::testing::TemporaryFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();

TEST(ReadFile, GivesEveryByte) {
  const TemporaryFolder folder;
  for (const std::size_t size : {0U, 1U, 65535U, 65536U, 65537U, 300000U}) {
    std::string text(size, '\0');
    for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>(i * 7 % 251);
    const auto bytes = read_file(folder.write("file", text), kNoLimit);
    ASSERT_TRUE(bytes.ok());
    EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()), text);
  }
}

TEST(ReadFile, NamesTheFileThatIsMissing) {
  const auto bytes = read_file("/nowhere/at/all", kNoLimit);
  ASSERT_FALSE(bytes.ok());
  EXPECT_EQ(bytes.error().code, ErrorCode::io);
  EXPECT_EQ(bytes.error().message, "/nowhere/at/all: No such file or directory");
}

TEST(ReadFile, RefusesAFolder) {
  const TemporaryFolder folder;
  const auto bytes = read_file(folder.path(), kNoLimit);
  ASSERT_FALSE(bytes.ok());
  EXPECT_EQ(bytes.error().message, folder.path().string() + ": Is a directory");
}

TEST(ReadFile, RefusesMoreThanTheLimitAndAcceptsTheLimit) {
  const TemporaryFolder folder;
  const auto file = folder.write("file", "12345");
  EXPECT_TRUE(read_file(file, 5).ok());
  const auto bytes = read_file(file, 4);
  ASSERT_FALSE(bytes.ok());
  EXPECT_THAT(bytes.error().message, HasSubstr(file.string() + ": larger than the limit of 4 bytes"));
}

TEST(ReadFile, RefusesWhatMayNeverEndBehindAName) {
  const TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);  // nobody writes: opening it would wait
  std::filesystem::create_symlink("/dev/zero", folder / "zero");
  std::filesystem::create_symlink("/dev/stdin", folder / "stdin");
  for (const char* const name : {"pipe", "zero"}) {
    const auto bytes = read_file(folder / name, kNoLimit);
    ASSERT_FALSE(bytes.ok());
    EXPECT_EQ(bytes.error().message, (folder / name).string() + ": is not a regular file");
  }
  EXPECT_EQ(read_file("/dev/zero", kNoLimit).error().message, "/dev/zero: is not a regular file");
}

TEST(ReadFile, ReadsAnOpenPipeByItsNumberToItsEnd) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe(ends.data()), 0);
  const std::string text(200000, 'x');
  std::thread writer([&] {
    EXPECT_EQ(::write(ends[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
    ::close(ends[1]);
  });
  const auto bytes = read_file("/dev/fd/" + std::to_string(ends[0]), kNoLimit);
  writer.join();
  ::close(ends[0]);
  ASSERT_TRUE(bytes.ok()) << bytes.error().message;
  EXPECT_EQ(bytes->size(), text.size());
}

TEST(ReadFile, EndsReadingAnEndlessStreamAtTheLimit) {
  const int zero = ::open("/dev/zero", O_RDONLY);
  ASSERT_GE(zero, 0);
  const auto bytes = read_file("/dev/fd/" + std::to_string(zero), 1000000);
  ::close(zero);
  ASSERT_FALSE(bytes.ok());
  EXPECT_THAT(bytes.error().message, HasSubstr("larger than the limit of 1000000 bytes"));
}

TEST(ReadFile, ShowsANameOnOneLine) {
  const auto bytes = read_file("/nowhere/a\nfransac: forged \x1b[31m" + std::string(5000, 'x'), kNoLimit);
  ASSERT_FALSE(bytes.ok());
  EXPECT_THAT(bytes.error().message, ::testing::StartsWith("/nowhere/a\\x0afransac: forged \\x1b[31m"));
  EXPECT_LT(bytes.error().message.size(), 1200U);
}

TEST(WriteFile, WritesAndReplaces) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_file(folder / "file", std::string_view("first, longer")).ok());
  ASSERT_TRUE(write_file(folder / "file", std::string_view("second")).ok());
  EXPECT_EQ(read_text(folder / "file"), "second");
  EXPECT_THAT(folder.names(), ElementsAre("file"));
}

TEST(WriteFile, AcceptsANameAsLongAsTheSystemAllows) {
  const TemporaryFolder folder;
  const std::string name(255, 'n');
  ASSERT_TRUE(write_file(folder / name, std::string_view("text")).ok());
  EXPECT_THAT(folder.names(), ElementsAre(name));
}

TEST(WriteFile, KeepsThePermissionsOfWhatItReplaces) {
  const TemporaryFolder folder;
  const auto file = folder.write("file", "old");
  ASSERT_EQ(::chmod(file.c_str(), 0640), 0);
  ASSERT_TRUE(write_file(file, std::string_view("new")).ok());
  struct stat info {};
  ASSERT_EQ(::stat(file.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 07777U, 0640U);
}

TEST(WriteFile, WritesThroughALink) {
  const TemporaryFolder folder;
  const auto target = folder.write("elsewhere/target", "old");
  std::filesystem::create_symlink(target, folder / "link");
  ASSERT_TRUE(write_file(folder / "link", std::string_view("new")).ok());
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(read_text(target), "new");
}

TEST(WriteFile, AReaderThatHasTheOldFileOpenKeepsIt) {
  const TemporaryFolder folder;
  std::ifstream reader(folder.write("file", "old text"));
  ASSERT_TRUE(write_file(folder / "file", std::string_view("new")).ok());
  std::string seen;
  std::getline(reader, seen);
  EXPECT_EQ(seen, "old text");
}

TEST(WriteFile, ReportsAFullDevice) {
  const Status status = write_file("/dev/full", std::string_view("text"));
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::io);
  EXPECT_EQ(status.error().message, "/dev/full: No space left on device");
}

TEST(WriteFile, LeavesADeviceADevice) {
  ASSERT_TRUE(write_file("/dev/null", std::string_view("text")).ok());
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(WriteFile, AppendsToARedirectedStandardOutput) {
  const TemporaryFolder folder;
  const auto file = folder.write("file", "before ");
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_APPEND);
  ASSERT_GE(descriptor, 0);
  const Status status = write_file("/dev/fd/" + std::to_string(descriptor), std::string_view("after"));
  ::close(descriptor);
  ASSERT_TRUE(status.ok()) << status.error().message;
  EXPECT_EQ(read_text(file), "before after");
}

TEST(WriteFile, WritesIntoAPipe) {
  const TemporaryFolder folder;
  const auto pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::string seen;
  std::thread reader([&] { seen = read_text(pipe); });
  const std::string text(200000, 'x');
  EXPECT_TRUE(write_file(pipe, text).ok());
  reader.join();
  EXPECT_EQ(seen, text);
  EXPECT_THAT(folder.names(), ElementsAre("pipe"));
}

TEST(WriteFile, NamesTheFileWhoseFolderIsMissing) {
  const TemporaryFolder folder;
  const auto file = folder / "missing" / "file";
  const Status status = write_file(file, std::string_view("text"));
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().message, file.string() + ": No such file or directory");
  EXPECT_THAT(folder.names(), IsEmpty());
}

TEST(WriteFile, RefusesAFolder) {
  const TemporaryFolder folder;
  const Status status = write_file(folder.path(), std::string_view("text"));
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().message, folder.path().string() + ": Is a directory");
}

TEST(WriteFile, RefusesAFolderWhereNothingCanBeCreated) {
  const Status status = write_file("/proc/fransac-test", std::string_view("text"));  // refused to root, too
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().message, HasSubstr("/proc/fransac-test: "));
}

TEST(WriteFile, RespectsAReadOnlyFileAndFolder) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  const TemporaryFolder folder;
  const auto file = folder.write("file", "old");
  ASSERT_EQ(::chmod(file.c_str(), 0444), 0);
  const Status replaced = write_file(file, std::string_view("new"));
  ASSERT_EQ(::chmod(folder.path().c_str(), 0555), 0);
  const Status created = write_file(folder / "other", std::string_view("new"));
  ASSERT_EQ(::chmod(folder.path().c_str(), 0755), 0);
  ASSERT_FALSE(replaced.ok());
  ASSERT_FALSE(created.ok());
  EXPECT_EQ(replaced.error().message, file.string() + ": Permission denied");
  EXPECT_EQ(created.error().message, (folder / "other").string() + ": Permission denied");
  EXPECT_EQ(read_text(file), "old");
  EXPECT_THAT(folder.names(), ElementsAre("file"));
}

/// Files may grow to `bytes` and no further while this lives: a disk that fills up in the middle of a write.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &old_limit_);
    old_handler_ = ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, old_limit_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &old_limit_);
    ::signal(SIGXFSZ, old_handler_);
  }

 private:
  rlimit old_limit_{};
  void (*old_handler_)(int) = nullptr;
};

TEST(WriteFile, AWriteThatStopsHalfWayLeavesTheOldFileAndNoOther) {
  const TemporaryFolder folder;
  const auto file = folder.write("file", "old");
  const std::string text(100000, 'x');
  const Status status = [&] {
    const FileSizeLimit limit(5000);
    return write_file(file, text);
  }();
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().message, file.string() + ": File too large");
  EXPECT_EQ(read_text(file), "old");
  EXPECT_THAT(folder.names(), ElementsAre("file"));
}

TEST(WriteFile, MakesWhatALinkWithoutTargetLeadsTo) {
  const TemporaryFolder folder;
  std::filesystem::create_symlink("target", folder / "link");
  ASSERT_TRUE(write_file(folder / "link", std::string_view("new")).ok());
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(read_text(folder / "target"), "new");
}

TEST(WriteFile, NamesALinkThatLeadsInACircle) {
  const TemporaryFolder folder;
  std::filesystem::create_symlink("b", folder / "a");
  std::filesystem::create_symlink("a", folder / "b");
  const Status status = write_file(folder / "a", std::string_view("text"));
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().message, (folder / "a").string() + ": Too many levels of symbolic links");
}

TEST(WriteFile, ALinkToAnOpenFileStaysALink) {
  const TemporaryFolder folder;
  const int descriptor = ::open((folder / "file").c_str(), O_WRONLY | O_CREAT, 0600);
  ASSERT_GE(descriptor, 0);
  const std::string name = "/proc/self/fd/" + std::to_string(descriptor);
  std::filesystem::create_symlink(name, folder / "link");
  EXPECT_TRUE(write_file(folder / "link", std::string_view("text")).ok());
  ::close(descriptor);
  const Status closed = write_file(folder / "link", std::string_view("more"));
  EXPECT_EQ(read_text(folder / "file"), "text");
  EXPECT_EQ(std::filesystem::read_symlink(folder / "link"), name);
  ASSERT_FALSE(closed.ok());
  EXPECT_EQ(closed.error().message, (folder / "link").string() + ": Bad file descriptor");
}

TEST(OutputFile, HasItsNameWhenItIsWhole) {
  const TemporaryFolder folder;
  const auto file = folder.write("file", "old");
  {
    auto output = OutputFile::create(file);
    ASSERT_TRUE(output.ok());
    ASSERT_TRUE(output->write("one").ok());
    ASSERT_TRUE(output->write("two").ok());
    EXPECT_EQ(read_text(file), "old");
    ASSERT_TRUE(output->commit().ok());
    EXPECT_EQ(read_text(file), "onetwo");
  }
  EXPECT_THAT(folder.names(), ElementsAre("file"));
}

TEST(OutputFile, LeavesNothingWithoutACommit) {
  const TemporaryFolder folder;
  const auto file = folder.write("file", "old");
  {
    auto output = OutputFile::create(file);
    ASSERT_TRUE(output.ok());
    ASSERT_TRUE(output->write("new").ok());
    EXPECT_EQ(folder.names().size(), 2U);
  }
  EXPECT_THAT(folder.names(), ElementsAre("file"));
  EXPECT_EQ(read_text(file), "old");
}

TEST(OutputFile, SeveralOfOneNameDoNotMeet) {
  const TemporaryFolder folder;
  std::vector<OutputFile> outputs;
  for (const char* const text : {"first", "second", "third"}) {
    auto output = OutputFile::create(folder / "file");
    ASSERT_TRUE(output.ok());
    ASSERT_TRUE(output->write(text).ok());
    outputs.push_back(std::move(*output));
  }
  for (OutputFile& output : outputs) ASSERT_TRUE(output.commit().ok());
  EXPECT_EQ(read_text(folder / "file"), "third");
  EXPECT_THAT(folder.names(), ElementsAre("file"));
}

TEST(OutputFile, AFileThatNobodyElseMayReadStaysSoWhileItIsWritten) {
  const TemporaryFolder folder;
  const auto file = folder.write("file", "old");
  ASSERT_EQ(::chmod(file.c_str(), 0600), 0);
  auto output = OutputFile::create(file);
  ASSERT_TRUE(output.ok());
  for (const std::string& name : folder.names()) {
    struct stat info {};
    ASSERT_EQ(::stat((folder / name).c_str(), &info), 0);
    EXPECT_EQ(info.st_mode & 0077U, 0U) << name;
  }
}

TEST(OutputFile, ALinkInThePlaceOfItsTemporaryIsNotFollowed) {
  const TemporaryFolder folder;
  std::string temporary;
  {
    auto output = OutputFile::create(folder / "file");
    ASSERT_TRUE(output.ok());
    temporary = folder.names().front();
  }
  const auto precious = folder.write("precious", "mine");
  std::filesystem::create_symlink(precious, folder / temporary);
  ASSERT_TRUE(write_file(folder / "file", std::string_view("text")).ok());
  EXPECT_EQ(read_text(precious), "mine");
  EXPECT_EQ(read_text(folder / "file"), "text");
  EXPECT_FALSE(std::filesystem::is_symlink(folder / "file"));
}

TEST(OutputFolder, IsThereWhenAllIsInIt) {
  const TemporaryFolder folder;
  auto output = OutputFolder::create(folder / "out");
  ASSERT_TRUE(output.ok());
  ASSERT_TRUE(write_file(output->path() / "file", std::string_view("text")).ok());
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  ASSERT_TRUE(output->commit().ok());
  EXPECT_EQ(read_text(folder / "out/file"), "text");
  EXPECT_THAT(folder.names(), ElementsAre("out"));
}

TEST(OutputFolder, FillsAnEmptyOneAndKeepsIt) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "out");
  struct stat before {};
  struct stat after {};
  ASSERT_EQ(::stat((folder / "out").c_str(), &before), 0);
  {
    auto output = OutputFolder::create(folder / "out/");
    ASSERT_TRUE(output.ok());
    std::filesystem::create_directory(output->path() / "frame");
    ASSERT_TRUE(write_file(output->path() / "frame/depth", std::string_view("text")).ok());
    ASSERT_TRUE(output->commit().ok());
  }
  ASSERT_EQ(::stat((folder / "out").c_str(), &after), 0);
  EXPECT_EQ(before.st_ino, after.st_ino);
  EXPECT_EQ(read_text(folder / "out/frame/depth"), "text");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder / "out"), {}), 1);
}

TEST(OutputFolder, LeavesNothingWithoutACommitAndRefusesAFullOne) {
  const TemporaryFolder folder;
  {
    auto output = OutputFolder::create(folder / "out");
    ASSERT_TRUE(output.ok());
    ASSERT_TRUE(write_file(output->path() / "file", std::string_view("text")).ok());
  }
  EXPECT_THAT(folder.names(), IsEmpty());
  folder.write("full/notes", "mine");
  const auto output = OutputFolder::create(folder / "full");
  ASSERT_FALSE(output.ok());
  EXPECT_EQ(output.error().message, (folder / "full").string() + ": is not empty; choose a new folder");
}

}  // namespace
}  // namespace fransac::io

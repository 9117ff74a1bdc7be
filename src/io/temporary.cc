// SPDX-License-Identifier: Apache-2.0
#include "io/temporary.h"

#include <sys/file.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "io/detect.h"

namespace fransac::io {
namespace {

namespace fs = std::filesystem;

constexpr int kNames = 16;  // processes that may write one target at once

/// All temporaries of this process. Held while one begins or ends, so that abandon_all() misses none.
struct Registry {
  std::mutex mutex;
  std::set<fs::path> names;
};

Registry& registry() {
  static Registry& instance = *new Registry;  // never destroyed: threads may outlive main()
  return instance;
}

/// 64-bit FNV-1a: names of any length become names of one length.
std::uint64_t hash_of(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return hash;
}

fs::path name_for(const fs::path& folder, const fs::path& target, int number) {
  std::array<char, 16> hash{};
  char* const end = std::to_chars(hash.data(), hash.data() + hash.size(), hash_of(target.filename().native()), 16).ptr;
  return folder / (".fransac-" + std::string(hash.data(), end) + "-" + std::to_string(number) + ".tmp");
}

enum class Lock { taken, of_another, unsupported };

Lock try_lock(const Descriptor& descriptor) {
  if (::flock(descriptor.number(), LOCK_EX | LOCK_NB) == 0) return Lock::taken;
  return errno == EWOULDBLOCK ? Lock::of_another : Lock::unsupported;
}

/// Whether the name leads to what is open. While its lock is held nobody else changes that.
bool is_named(const Descriptor& descriptor, const fs::path& name) {
  struct stat open {};
  struct stat named {};
  return ::fstat(descriptor.number(), &open) == 0 && ::lstat(name.c_str(), &named) == 0 && open.st_dev == named.st_dev &&
         open.st_ino == named.st_ino;
}

void remove_anything(const fs::path& name) {
  std::error_code ignored;
  if (::unlink(name.c_str()) != 0) fs::remove_all(name, ignored);
}

}  // namespace

void Temporary::remove_stale(const fs::path& folder, const fs::path& target) {
  for (int i = 0; i < kNames; ++i) {
    const fs::path name = name_for(folder, target, i);
    Descriptor descriptor = open_file(name, O_WRONLY | O_NOFOLLOW | O_NONBLOCK);  // network file systems lock only such
    if (!descriptor.valid() && errno == EISDIR) descriptor = open_file(name, O_RDONLY | O_NOFOLLOW | O_DIRECTORY);
    if (descriptor.valid() && try_lock(descriptor) == Lock::taken && is_named(descriptor, name)) remove_anything(name);
  }
}

template <class Make>
Result<Temporary> Temporary::make(const fs::path& folder, const fs::path& target, const fs::path& shown, const Make& make_one) {
  remove_stale(folder, target);
  const std::lock_guard lock(registry().mutex);
  for (int i = 0; i < kNames; ++i) {
    fs::path name = name_for(folder, target, i);
    fs::path shown_name = shown;  // nothing that can fail comes between the name's registration and its owner
    const auto [entry, is_new] = registry().names.insert(name);
    if (!is_new) continue;
    Descriptor descriptor = make_one(name);
    const int error = errno;
    // Another process may have taken it for stale before it was locked.
    if (descriptor.valid() && try_lock(descriptor) != Lock::of_another && is_named(descriptor, name)) {
      return Temporary(std::move(name), std::move(shown_name), std::move(descriptor));
    }
    registry().names.erase(entry);
    if (!descriptor.valid() && error != EEXIST && error != ENOENT) return errno_error(shown, error);
    struct stat info {};
    if (!descriptor.valid() && error == ENOENT && ::stat(folder.c_str(), &info) != 0) return errno_error(shown, error);
  }
  return io_error(shown, "too many processes are writing it");
}

Result<Temporary> Temporary::make_file(const fs::path& folder, const fs::path& target, const fs::path& shown, mode_t mode) {
  return make(folder, target, shown, [&](const fs::path& name) { return open_file(name, O_WRONLY | O_CREAT | O_EXCL, mode); });
}

Result<Temporary> Temporary::make_folder(const fs::path& folder, const fs::path& target, const fs::path& shown) {
  return make(folder, target, shown, [](const fs::path& name) {
    return ::mkdir(name.c_str(), mode_t{0777}) == 0 ? open_file(name, O_RDONLY | O_DIRECTORY) : Descriptor();
  });
}

Temporary::Temporary(Temporary&& other) noexcept
    : name_(std::exchange(other.name_, fs::path())), shown_(std::move(other.shown_)), descriptor_(std::move(other.descriptor_)) {}

Temporary::~Temporary() {
  if (name_.empty()) return;
  try {
    const std::lock_guard lock(registry().mutex);
    registry().names.erase(name_);
    remove_anything(name_);
  } catch (...) {  // the next run removes it
  }
}

Status Temporary::move_to(const fs::path& target) {
  if (::fsync(descriptor_.number()) != 0 && errno != EINVAL) return errno_error(shown_, errno);  // EINVAL: cannot be synchronised
  const Descriptor lock_holder(::fcntl(descriptor_.number(), F_DUPFD_CLOEXEC, 0));  // the lock lasts until all are closed
  if (!descriptor_.close()) return errno_error(shown_, errno);
  const std::lock_guard lock(registry().mutex);
  if (::rename(name_.c_str(), target.c_str()) != 0) return errno_error(shown_, errno);
  registry().names.erase(name_);
  name_.clear();
  return {};
}

Status Temporary::move_content_to(const fs::path& folder) {
  Result<std::vector<fs::path>> entries = sorted_entries(name_);
  if (!entries) return entries.error();
  std::stable_partition(entries->begin(), entries->end(), [](const fs::path& entry) { return !is_file(entry); });
  const std::lock_guard lock(registry().mutex);
  for (const fs::path& entry : *entries) {
    if (::rename(entry.c_str(), (folder / entry.filename()).c_str()) != 0) return errno_error(shown_ / entry.filename(), errno);
  }
  return {};
}

void Temporary::abandon_all() noexcept {
  try {
    registry().mutex.lock();  // for good
    for (const fs::path& name : registry().names) remove_anything(name);
  } catch (...) {  // the next run removes what is left
  }
}

}  // namespace fransac::io

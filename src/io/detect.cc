// SPDX-License-Identifier: Apache-2.0
#include "io/detect.h"

#include <dirent.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <system_error>

#include "io/file_head.h"
#include "io/guard.h"
#include "io/raw_depth.h"
#include "io/text.h"

namespace fransac::io {
namespace {

namespace fs = std::filesystem;
using namespace std::string_view_literals;

// Enough for the comments before a PCD's first field.
constexpr std::size_t kHeadBytes = 4096;

// A PNG's signature and header chunk as far as its bit depth and colour type (PNG specification, 5.2 and 11.2.2).
constexpr std::string_view kPngStart = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR"sv;
constexpr std::size_t kPngBitDepthAt = 24;
constexpr std::string_view kSixteenBitGrey = "\x10\0"sv;

constexpr std::array<const char*, 5> kDepthNames{"depth.png", "depth.tiff", "depth.tif", "depth.pgm", "depth.npy"};

bool starts_like_pcd(std::string_view head) {
  if (head.starts_with("# .PCD")) return true;
  while (head.starts_with('#') || head.starts_with('\n') || head.starts_with('\r')) {
    const std::size_t end = head.find('\n');
    if (end == std::string_view::npos) return false;
    head.remove_prefix(end + 1);
  }
  return head.starts_with("VERSION ") || head.starts_with("VERSION\t");
}

std::optional<InputKind> kind_of_name(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return std::tolower(c); });
  constexpr std::array<std::string_view, 5> kImages{".png", ".tiff", ".tif", ".pgm", ".npy"};
  if (std::find(kImages.begin(), kImages.end(), extension) != kImages.end()) return InputKind::depth_image;
  if (extension == ".pcd") return InputKind::pcd;
  if (extension == ".ply") return InputKind::ply;
  if (extension == ".xyz") return InputKind::xyz;
  return std::nullopt;
}

Error unknown(const fs::path& input, const std::string& what) { return file_error(ErrorCode::format, input.native(), what); }

Result<InputKind> kind_of_file(const fs::path& file) {
  const Result<std::vector<std::byte>> head = read_head(file, kHeadBytes);
  if (!head) return head.error();
  if (const auto kind = kind_of_content(as_text(*head))) return *kind;
  if (const auto kind = kind_of_name(file)) return *kind;
  return unknown(file, "neither a depth image (PNG, TIFF, PGM, NPY) nor a PCD, PLY or XYZ file");
}

Result<InputKind> kind_of_folder(const fs::path& folder) {
  if (is_tum_sequence(folder)) return InputKind::tum_sequence;
  if (depth_in(folder)) return InputKind::frame;
  if (is_file(folder / "dataset.json")) return InputKind::dataset;
  const Result<std::vector<fs::path>> entries = sorted_entries(folder);
  if (!entries) return entries.error();
  const auto holds_frame = [](const fs::path& entry) { return depth_in(entry) || is_depth_image(entry); };
  if (std::any_of(entries->begin(), entries->end(), holds_frame)) return InputKind::dataset;
  return unknown(folder,
                 "no frame in this folder: no depth.png, no depth.txt or associations.txt, no dataset.json, no sub-folder with a "
                 "depth.png and no depth image");
}

}  // namespace

bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

bool is_named_depth(const fs::path& file) {
  return std::find(kDepthNames.begin(), kDepthNames.end(), file.filename()) != kDepthNames.end();
}

std::optional<fs::path> depth_in(const fs::path& folder) {
  for (const char* const name : kDepthNames) {
    if (is_file(folder / name)) return folder / name;
  }
  return std::nullopt;
}

bool is_tum_sequence(const fs::path& folder) { return is_file(folder / "depth.txt") || is_file(folder / kTumAssociations); }

bool is_depth_image(const fs::path& file) {
  if (!is_file(file)) return false;
  const Result<std::vector<std::byte>> head = read_head(file, kPngBitDepthAt + kSixteenBitGrey.size());
  if (!head) return false;
  const std::string_view text = as_text(*head);
  const std::optional<DepthFileFormat> format = depth_format_of(text);
  if (format != DepthFileFormat::png) return format.has_value();
  return text.starts_with(kPngStart) && text.ends_with(kSixteenBitGrey) && text.size() == kPngBitDepthAt + kSixteenBitGrey.size();
}

std::optional<InputKind> kind_of_content(std::string_view head) {
  if (head.starts_with(kByteOrderMark)) head.remove_prefix(kByteOrderMark.size());
  if (depth_format_of(head)) return InputKind::depth_image;
  if (head.starts_with("ply\n") || head.starts_with("ply\r")) return InputKind::ply;
  if (starts_like_pcd(head)) return InputKind::pcd;
  return std::nullopt;
}

Result<std::vector<fs::path>> sorted_entries(const fs::path& folder) {
  std::vector<fs::path> entries;
  // std::filesystem's iterator ends the program where it gets no memory.
  const auto close = [](DIR* open) { ::closedir(open); };
  const std::unique_ptr<DIR, decltype(close)> stream(::opendir(folder.c_str()), close);
  errno = stream ? 0 : errno;
  while (const dirent* const entry = stream ? ::readdir(stream.get()) : nullptr) {
    const std::string_view name = entry->d_name;
    if (name != "." && name != "..") entries.push_back(folder / name);
    errno = 0;
  }
  if (errno == ENOMEM) throw std::bad_alloc();
  if (errno != 0) return file_error(ErrorCode::io, folder.native(), std::generic_category().message(errno));
  std::sort(entries.begin(), entries.end());
  return entries;
}

bool is_cloud(InputKind kind) { return kind == InputKind::pcd || kind == InputKind::ply || kind == InputKind::xyz; }

std::string_view to_string(InputKind kind) {
  switch (kind) {
    case InputKind::depth_image: return "depth_image";
    case InputKind::frame: return "frame";
    case InputKind::dataset: return "dataset";
    case InputKind::tum_sequence: return "tum_sequence";
    case InputKind::pcd: return "pcd";
    case InputKind::ply: return "ply";
    case InputKind::xyz: return "xyz";
  }
  return "unknown";
}

Result<InputKind> detect_kind(const fs::path& input) {
  return guarded(input.native(), [&]() -> Result<InputKind> {
    std::error_code error;
    const fs::file_status status = fs::status(input, error);
    if (!fs::status_known(status) || !fs::exists(status)) {
      if (!error) error = std::make_error_code(std::errc::no_such_file_or_directory);
      return file_error(ErrorCode::io, input.native(), error.message());
    }
    if (fs::is_directory(status)) return kind_of_folder(input);
    if (fs::is_regular_file(status)) return kind_of_file(input);
    return unknown(input, "neither a file nor a folder");
  });
}

}  // namespace fransac::io

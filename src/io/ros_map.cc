// SPDX-License-Identifier: Apache-2.0
#include "fransac/io/ros_map.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <string>

#include "fransac/io/file.hpp"
#include "io/guard.h"

namespace fransac::io {
namespace {

namespace fs = std::filesystem;

// In the mode "trinary" map_server takes p = (255 - value) / 255 above occupied_thresh for occupied, below free_thresh for free.
constexpr std::uint8_t kFreeGrey = 254;
constexpr std::uint8_t kOccupiedGrey = 0;
constexpr std::uint8_t kUnknownGrey = 205;

char grey(std::int8_t cell) {
  const std::uint8_t value = cell == OccupancyGrid::kFree       ? kFreeGrey
                             : cell == OccupancyGrid::kOccupied ? kOccupiedGrey
                                                                : kUnknownGrey;
  return static_cast<char>(value);
}

std::string pgm(const OccupancyGrid& grid) {
  std::string image = "P5\n" + std::to_string(grid.width) + " " + std::to_string(grid.height) + "\n255\n";
  const std::size_t head = image.size();
  image.resize(head + grid.cells.size());
  for (std::size_t row = 0; row < static_cast<std::size_t>(grid.height); ++row) {
    const auto width = static_cast<std::ptrdiff_t>(grid.width);
    const auto cells = grid.cells.end() - static_cast<std::ptrdiff_t>(row + 1) * width;
    std::transform(cells, cells + width,
                   image.begin() + static_cast<std::ptrdiff_t>(head + row * static_cast<std::size_t>(width)), grey);
  }
  return image;
}

/// The shortest digits that read as the same number, whatever the locale.
std::string digits(double number) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr};
}

/// A YAML scalar in single quotes, in which a quote is written twice and nothing else has a meaning.
std::string yaml_string(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result.append(c == '\'' ? 2 : 1, c);
  return result + "'";
}

std::string yaml(const std::string& image, const OccupancyGrid& grid) {
  return "image: " + yaml_string(image) + "\nmode: trinary\nresolution: " + digits(grid.resolution_m) + "\norigin: [" +
         digits(grid.origin_m.x()) + ", " + digits(grid.origin_m.y()) +
         ", 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
}

fs::path with_suffix(fs::path base, const char* suffix) { return base += suffix; }

}  // namespace

Result<RosMap> encode_ros_map(const fs::path& base, const OccupancyGrid& grid) {
  return guarded(base.native(), [&]() -> Result<RosMap> {
    if (!base.has_filename()) return file_error(ErrorCode::invalid_argument, base.native(), "names no file");
    if (grid.width <= 0 || grid.height <= 0) return file_error(ErrorCode::no_data, base.native(), "the grid has no squares");
    if (grid.cells.size() != static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height)) {
      return file_error(ErrorCode::invalid_argument, base.native(), "the grid's cells are not width x height");
    }
    return RosMap{pgm(grid), yaml(with_suffix(base, ".pgm").filename().string(), grid)};
  });
}

Status write_ros_map(const fs::path& base, const OccupancyGrid& grid) {
  const Result<RosMap> map = encode_ros_map(base, grid);
  if (!map) return map.error();
  return guarded(base.native(), [&]() -> Status {
    Result<OutputFile> image = OutputFile::create(with_suffix(base, ".pgm"));
    if (!image) return image.error();
    Result<OutputFile> description = OutputFile::create(with_suffix(base, ".yaml"));
    if (!description) return description.error();
    Status status = image->write(map->pgm);
    if (status) status = description->write(map->yaml);
    if (status) status = image->commit();
    return status ? description->commit() : status;
  });
}

}  // namespace fransac::io

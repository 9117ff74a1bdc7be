// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <string>

#include "fransac/io/ros_map.hpp"
#include "temporary_folder.h"

namespace fransac::io {
namespace {

using fransac::testing::read_text;
using fransac::testing::TemporaryFolder;
using namespace std::string_literals;

constexpr std::int8_t kFree = OccupancyGrid::kFree;
constexpr std::int8_t kOccupied = OccupancyGrid::kOccupied;
constexpr std::int8_t kUnknown = OccupancyGrid::kUnknown;

/// Two squares along x, three along y.
OccupancyGrid small_grid() {
  return {.resolution_m = 0.05,
          .width = 2,
          .height = 3,
          .origin_m = {-0.1, -1.25},
          .cells = {kFree, kOccupied, kUnknown, kFree, kOccupied, kUnknown}};
}

TEST(RosMap, TheImageStartsWithTheLargestY) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_ros_map(folder / "map", small_grid()).ok());
  EXPECT_EQ(read_text(folder / "map.pgm"), "P5\n2 3\n255\n\x00\xCD\xCD\xFE\xFE\x00"s);
}

TEST(RosMap, TheDescriptionIsWhatMapServerReads) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_ros_map(folder / "it's v1.2", small_grid()).ok());
  EXPECT_EQ(read_text(folder / "it's v1.2.yaml"),
            "image: 'it''s v1.2.pgm'\n"
            "mode: trinary\n"
            "resolution: 0.05\n"
            "origin: [-0.1, -1.25, 0]\n"
            "negate: 0\n"
            "occupied_thresh: 0.65\n"
            "free_thresh: 0.196\n");
  EXPECT_EQ(folder.names().size(), 2U);
}

TEST(RosMap, ErrorsNameTheBase) {
  const TemporaryFolder folder;
  OccupancyGrid short_of_cells = small_grid();
  short_of_cells.cells.pop_back();
  EXPECT_EQ(write_ros_map(folder / "map", short_of_cells).error().code, ErrorCode::invalid_argument);
  EXPECT_EQ(write_ros_map(folder / "map", OccupancyGrid{}).error().code, ErrorCode::no_data);
  EXPECT_EQ(write_ros_map(folder / "", small_grid()).error().code, ErrorCode::invalid_argument);
  const Status missing = write_ros_map(folder / "none" / "map", small_grid());
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::io);
  EXPECT_THAT(missing.error().message, ::testing::HasSubstr("none/map.pgm"));
  EXPECT_TRUE(folder.names().empty());
}

}  // namespace
}  // namespace fransac::io

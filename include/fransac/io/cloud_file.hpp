// SPDX-License-Identifier: Apache-2.0
/// Point clouds as files: PCD, PLY and XYZ.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "fransac/core/point_cloud.hpp"
#include "fransac/core/result.hpp"
#include "fransac/io/limits.hpp"

namespace fransac::io {

/// How the points of a file are written.
enum class CloudEncoding { ascii, binary, binary_compressed };  ///< binary_compressed is PCD only.

/// Reads a PCD (ascii, binary, binary_compressed), PLY (ascii, binary, both byte orders) or XYZ file (lines "x y z" and whatever
/// follows, apart by blanks, commas or semicolons); which it is, is found from the content, XYZ by the name's ending. Needs
/// fields x, y, z (or X, Y, Z) of any type of number. `metres_per_unit`: what a unit of the file's coordinates is, 0.001 where
/// they are millimetres; finite and above 0, else invalid_argument. The origin is chosen near the cloud's centre when its
/// coordinates are too large for float (|coordinate| > 1000 m), else zero. Organised clouds keep width x height.
/// Points that are not finite are NaN on all axes.
/// A PCD's VIEWPOINT says where the sensor was (PointCloud::sensor_position), in the points' own coordinates, as PCL's estimation
/// of normals takes it; the points are not moved or turned by it. A translation of 0 0 0 is what PCL writes where it knows none,
/// and stands for an unknown position.
/// Points at (0, 0, 0) are read as they stand; segment() takes them for "no return" (PointCloud::measured).
/// A header that promises no points gives an empty cloud.
/// Every size in the header is checked against the file's size and `limits` before memory is taken.
Result<PointCloud> read_cloud(const std::filesystem::path& file, double metres_per_unit = 1.0, const ReadLimits& limits = {});

/// Writes a cloud as PCD or PLY (by the file's extension, .pcd or .ply), with a colour per point by label when `labels`
/// is not empty (one per point; io::label_colour; grey for no plane) and the label itself as a field of 32 bits.
/// `obstacles`, unless empty: the id of each point's obstacle, 0 for none, as another such field, named obstacle.
/// x, y, z are in the input's coordinates: floats, or doubles when the cloud has an origin. Temporary name, then renamed.
/// Errors: invalid_argument for another extension, a number of labels or ids that is not the number of points, or a PLY
/// binary_compressed; no_data for a cloud without points.
Status write_cloud(const std::filesystem::path& file, const PointCloud& cloud, std::span<const std::uint8_t> labels,
                   CloudEncoding encoding = CloudEncoding::binary, std::span<const std::uint16_t> obstacles = {});
/// The bytes that write_cloud writes, and its errors; `file` is only a name.
Result<std::string> encode_cloud(const std::filesystem::path& file, const PointCloud& cloud, std::span<const std::uint8_t> labels,
                                 CloudEncoding encoding = CloudEncoding::binary, std::span<const std::uint16_t> obstacles = {});

}  // namespace fransac::io

// SPDX-License-Identifier: Apache-2.0
// PCD and PLY in memory. `name` stands for the file in messages. The functions may throw std::bad_alloc, except
// decode_cloud, which is the boundary.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "fransac/core/point_cloud.hpp"
#include "fransac/core/result.hpp"
#include "fransac/io/cloud_file.hpp"

namespace fransac::io::cloud_formats {

Result<PointCloud> decode_pcd(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits = {});
Result<PointCloud> decode_ply(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits = {});
/// Lines of text, each "x y z" and what else there may be, apart by blanks, commas or semicolons; '#' and "//" start comments. A
/// first line of words names the columns, a first number alone counts the points. `name` stands for the file in messages.
Result<PointCloud> decode_xyz(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits = {});
/// Any of them: from the content, text without a header by the name's ending .xyz.
Result<PointCloud> decode_cloud(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits = {});

/// What is written: a cloud with points, planes' labels and obstacles' ids, each one per point or none at all.
struct LabelledCloud {
  const PointCloud& cloud;
  std::span<const std::uint8_t> labels;
  std::span<const std::uint16_t> obstacles;
};
Result<std::string> encode_pcd(const LabelledCloud& labelled, CloudEncoding encoding, const std::string& name);
std::string encode_ply(const LabelledCloud& labelled, CloudEncoding encoding);

}  // namespace fransac::io::cloud_formats

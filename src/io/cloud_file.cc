// SPDX-License-Identifier: Apache-2.0
#include "fransac/io/cloud_file.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "fransac/io/file.hpp"
#include "io/cloud_assemble.h"
#include "io/cloud_formats.h"
#include "io/cloud_text.h"
#include "io/detect.h"
#include "io/guard.h"
#include "io/text.h"

namespace fransac::io {
namespace {

std::string lower_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

}  // namespace

namespace cloud_formats {

Result<PointCloud> decode_cloud(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits) {
  return guarded(name, [&]() -> Result<PointCloud> {
    if (as_text(bytes).starts_with(kByteOrderMark)) bytes = bytes.subspan(kByteOrderMark.size());
    if (bytes.empty()) return format_error(name, "is empty");
    const std::optional<InputKind> kind = kind_of_content(as_text(bytes));
    if (kind == InputKind::ply) return decode_ply(bytes, name, limits);
    if (kind != InputKind::pcd && lower_extension(name) == ".xyz") return decode_xyz(bytes, name, limits);
    return decode_pcd(bytes, name, limits);
  });
}

}  // namespace cloud_formats

Result<PointCloud> read_cloud(const std::filesystem::path& file, double metres_per_unit, const ReadLimits& limits) {
  return guarded(file.native(), [&]() -> Result<PointCloud> {
    if (!(metres_per_unit > 0.0) || !std::isfinite(metres_per_unit)) {
      return file_error(ErrorCode::invalid_argument, file.native(), "metres_per_unit must be finite and above 0");
    }
    const auto bytes = read_file(file, limits.max_cloud_file_bytes());
    if (!bytes) return bytes.error();
    Result<PointCloud> cloud = cloud_formats::decode_cloud(*bytes, file.string(), limits);
    if (!cloud || metres_per_unit == 1.0) return cloud;
    const auto width = static_cast<std::size_t>(cloud->width);
    PointCloud scaled =
        cloud_formats::assemble(width, width == 0 ? 0 : cloud->size() / width,
                                [&](std::size_t i) -> Eigen::Vector3d { return metres_per_unit * cloud->point(i); });
    if (cloud->sensor_position) scaled.sensor_position = metres_per_unit * *cloud->sensor_position;
    return scaled;
  });
}

Result<std::string> encode_cloud(const std::filesystem::path& file, const PointCloud& cloud, std::span<const std::uint8_t> labels,
                                 CloudEncoding encoding, std::span<const std::uint16_t> obstacles) {
  return guarded(file.native(), [&]() -> Result<std::string> {
    const std::string extension = lower_extension(file);
    if (extension != ".pcd" && extension != ".ply") {
      return file_error(ErrorCode::invalid_argument, file.native(), "the name of a cloud must end in .pcd or .ply");
    }
    if (extension == ".ply" && encoding == CloudEncoding::binary_compressed) {
      return file_error(ErrorCode::invalid_argument, file.native(), "PLY has no binary_compressed encoding");
    }
    for (const std::size_t size : {labels.size(), obstacles.size()}) {
      if (size == 0 || size == cloud.size()) continue;
      return file_error(ErrorCode::invalid_argument, file.native(),
                        std::to_string(size) + " labels for " + std::to_string(cloud.size()) + " points");
    }
    if (cloud.empty()) return file_error(ErrorCode::no_data, file.native(), "the cloud to write has no points");
    if (cloud.sensor_position) {
      if (const Status status = validate_position(*cloud.sensor_position, "sensor position"); !status) {
        return file_error(status.error().code, file.native(), status.error().message);
      }
    }
    const cloud_formats::LabelledCloud labelled{cloud, labels, obstacles};
    if (extension == ".ply") return cloud_formats::encode_ply(labelled, encoding);
    return cloud_formats::encode_pcd(labelled, encoding, file.string());
  });
}

Status write_cloud(const std::filesystem::path& file, const PointCloud& cloud, std::span<const std::uint8_t> labels,
                   CloudEncoding encoding, std::span<const std::uint16_t> obstacles) {
  return guarded(file.native(), [&]() -> Status {
    const Result<std::string> text = encode_cloud(file, cloud, labels, encoding, obstacles);
    return text ? write_file(file, std::string_view(*text)) : text.error();
  });
}

}  // namespace fransac::io

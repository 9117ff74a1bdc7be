// SPDX-License-Identifier: Apache-2.0
/// dataset.json: what is known of all frames of a folder.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "fransac/core/result.hpp"
#include "fransac/io/dataset.hpp"

namespace fransac::io {

/// What dataset.json says.
struct DatasetJson {
  Truth truth = Truth::none;
  std::string sensor;
  std::optional<int> floor;  ///< Its label.

  bool operator==(const DatasetJson&) const = default;
};

/// Reads {"truth": "none", "dominant" or "planes", "sensor": text, "floor": label}, all of which may be missing. Other fields are
/// ignored. May throw std::bad_alloc.
Result<DatasetJson> parse_dataset_json(std::string_view text, const std::string& name);

/// The same format. Throws std::exception when the sensor is not UTF-8.
std::string dataset_to_json(const DatasetJson& dataset);

}  // namespace fransac::io

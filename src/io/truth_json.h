// SPDX-License-Identifier: Apache-2.0
/// truth.json: the coefficients of a frame's annotated planes, its objects, and where its camera is.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fransac/core/plane.hpp"
#include "fransac/core/result.hpp"
#include "fransac/io/dataset.hpp"
#include "fransac/io/image.hpp"

namespace fransac::io {

using LabelledPlanes = std::vector<std::pair<int, Plane>>;

/// What is read of truth.json.
struct TruthJson {
  LabelledPlanes planes;
  std::optional<int> floor;  ///< Its label; 0: none is seen; nothing: it does not say.
};

/// Reads {"floor": label or null, "planes": [{"label", "normal": [3], "d"}, …]}; "floor" may be missing, the normals may have
/// either sign. Other fields are ignored. May throw std::bad_alloc.
Result<TruthJson> parse_truth_json(std::string_view text, const std::string& name);

/// The same format and all else that is known of the frame; with labels also how many pixels of the depth image each label has.
std::string truth_to_json(const FrameToWrite& frame);

}  // namespace fransac::io

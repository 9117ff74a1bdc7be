// SPDX-License-Identifier: Apache-2.0
/// truth.json: the coefficients of a frame's annotated planes, its objects, and where its camera is.
#pragma once

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

/// Reads {"planes": [{"label", "normal": [3], "d"}, …]}; the normals may have either sign. Other fields are ignored.
/// May throw std::bad_alloc.
Result<LabelledPlanes> parse_truth_json(std::string_view text, const std::string& name);

/// The same format and all else that is known of the frame; with labels also how many pixels of the depth image each label has.
std::string truth_to_json(const FrameToWrite& frame);

}  // namespace fransac::io

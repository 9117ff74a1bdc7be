// SPDX-License-Identifier: Apache-2.0
/// The free-standing things of a scene: how large they are and what they stand on.
#pragma once

#include <vector>

#include "fransac/core/true_object.hpp"
#include "synth/geometry.hpp"

namespace fransac::synth::detail {

/// The objects with an id, in the scene's frame. A box is turned as the object's first solid is, and tight at that angle.
std::vector<TrueObject> things_of(const Scene& scene);

}  // namespace fransac::synth::detail

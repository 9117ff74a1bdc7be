// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fransac/planes/segment.hpp"

namespace fransac {

/// Numbers the planes in the order that they stand in, and makes the labels follow. Their ids were their labels until now, up to
/// `numbered`; pixels and points of planes that are gone are on none.
void renumber(int numbered, Segmentation& segmentation);

}  // namespace fransac

// SPDX-License-Identifier: Apache-2.0
#include "planes/renumber.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

#include "kernels/labels.h"

namespace fransac {

void renumber(int numbered, Segmentation& segmentation) {
  bool changed = static_cast<int>(segmentation.planes.size()) < numbered;
  std::array<std::uint8_t, 256> label{};
  label.fill(kLabelNoPlane);
  label[kLabelNoDepth] = kLabelNoDepth;
  int id = kLabelFirst;
  for (PlaneSegment& plane : segmentation.planes) {
    changed = changed || plane.id != id;
    label[static_cast<std::size_t>(plane.id)] = static_cast<std::uint8_t>(id);
    plane.id = id++;
  }
  if (changed) kernels::relabel(segmentation.labels.data(), segmentation.labels.size(), label.data(), numbered);
}

}  // namespace fransac

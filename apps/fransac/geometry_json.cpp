// SPDX-License-Identifier: Apache-2.0
#include "geometry_json.hpp"

#include <utility>

namespace fransac::cli {
namespace {

nlohmann::ordered_json ring_to_json(const Ring& ring) {
  return {{"pixels", vectors_to_json(ring.pixels)}, {"points", vectors_to_json(ring.points)}};
}

}  // namespace

nlohmann::ordered_json outlines_to_json(const std::vector<Outline>& outlines) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Outline& outline : outlines) {
    nlohmann::ordered_json holes = nlohmann::ordered_json::array();
    for (const Ring& hole : outline.holes) holes.push_back(ring_to_json(hole));
    json.push_back({{"outer", ring_to_json(outline.outer)}, {"holes", std::move(holes)}});
  }
  return json;
}

}  // namespace fransac::cli

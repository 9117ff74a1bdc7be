// SPDX-License-Identifier: Apache-2.0
// truth.json and dataset.json: any text is what it says, which survives a round trip, or an error that names the file.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>

#include "fransac/core/labels.hpp"
#include "io/dataset_json.h"
#include "io/truth_json.h"
#include "require.hpp"

namespace {

using namespace fransac;
using namespace fransac::fuzz;

bool is_label(int label) { return label >= kLabelFirst && label <= kMaxPlanes; }

bool near(double a, double b) { return std::abs(a - b) <= 1e-12 * (1.0 + std::abs(a)); }

void check_truth(std::string_view text) {
  const Result<io::TruthJson> truth = io::parse_truth_json(text, "truth.json");
  if (!truth) return require_message(truth.error(), "truth.json: ");
  std::set<int> labels;
  for (const auto& [label, plane] : truth->planes) {
    require(is_label(label) && labels.insert(label).second);
    require(std::abs(plane.normal.norm() - 1.0) < 1e-9 && std::isfinite(plane.d) && plane.d >= 0.0);
  }
  require(!truth->floor || *truth->floor == kLabelNoDepth || is_label(*truth->floor));
  io::FrameToWrite frame;
  frame.true_planes = truth->planes;
  frame.floor = truth->floor;
  const Result<io::TruthJson> again = io::parse_truth_json(io::truth_to_json(frame), "again");
  require(again && again->floor == truth->floor && again->planes.size() == truth->planes.size());
  for (std::size_t i = 0; i < truth->planes.size(); ++i) {
    const auto& [label, plane] = truth->planes[i];
    require(again->planes[i].first == label && near(plane.d, again->planes[i].second.d));
    require((plane.normal - again->planes[i].second.normal).norm() < 1e-12);
  }
}

void check_dataset(std::string_view text) {
  const Result<io::DatasetJson> dataset = io::parse_dataset_json(text, "dataset.json");
  if (!dataset) return require_message(dataset.error(), "dataset.json: ");
  require(!dataset->floor || is_label(*dataset->floor));
  const Result<io::DatasetJson> again = io::parse_dataset_json(io::dataset_to_json(*dataset), "again");
  require(again && *again == *dataset);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  check_truth(text);
  check_dataset(text);
  return 0;
}

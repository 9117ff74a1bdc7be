// SPDX-License-Identifier: Apache-2.0
// What object metrics must be whatever the images are.
#include <algorithm>
#include <vector>

#include "fransac/eval/metrics.hpp"
#include "property.hpp"

namespace fransac::eval {
namespace {

using testing::any_stream;
using testing::check_property;
using Ids = std::vector<std::uint16_t>;

/// Blocks of pixels of at most `most` objects, ids anywhere in 16 bits; about a third has none.
Ids any_objects(RandomStream& random, std::size_t pixels, std::uint32_t most) {
  Ids palette(most);
  for (std::uint16_t& id : palette) id = static_cast<std::uint16_t>(1 + random.below(65535));
  Ids ids;
  while (ids.size() < pixels) {
    const std::uint16_t id = random.below(3) == 0 ? std::uint16_t{0} : palette[random.below(most)];
    ids.insert(ids.end(), 1 + random.below(20), id);
  }
  ids.resize(pixels);
  return ids;
}

/// Other numbers for the same objects: multiplying by an odd number permutes 16 bits and leaves 0 in place.
Ids renumbered(Ids ids) {
  for (std::uint16_t& id : ids) id = static_cast<std::uint16_t>(id * 40503U);
  return ids;
}

TEST(ObjectMetricsProperty, APerfectPredictionIsPerfectWhateverItsNumbers) {
  check_property(100, [] {
    RandomStream random = any_stream();
    const Ids truth = any_objects(random, 400, 1 + random.below(40));
    const auto metrics = object_metrics(truth, renumbered(truth), std::vector<std::uint8_t>(truth.size(), 1));
    RC_ASSERT(metrics.ok());
    RC_ASSERT(metrics->true_objects == metrics->predicted_objects);
    RC_ASSERT(metrics->at75.matched == metrics->true_objects);
    RC_ASSERT(metrics->false_objects == 0);
    RC_ASSERT(metrics->over_segmentation == 0.0 && metrics->under_segmentation == 0.0);
    for (const auto& object : metrics->objects) RC_ASSERT(object.iou == 1.0);
  });
}

TEST(ObjectMetricsProperty, NumbersDoNotMatterAndSidesMirrorEachOther) {
  check_property(100, [] {
    RandomStream random = any_stream();
    const Ids truth = any_objects(random, 400, 1 + random.below(40));
    Ids predicted = any_objects(random, 400, 1 + random.below(40));
    std::copy_n(truth.begin(), random.below(400), predicted.begin());  // right as far as that
    std::vector<std::uint8_t> judged(truth.size());
    for (std::uint8_t& value : judged) value = static_cast<std::uint8_t>(random.below(4));
    const auto metrics = object_metrics(truth, predicted, judged);
    const auto other = object_metrics(truth, renumbered(predicted), judged);
    const auto mirrored = object_metrics(predicted, truth, judged);
    RC_ASSERT(metrics.ok() && other.ok() && mirrored.ok());
    // Matches above one half are unique; at exactly one half their number may depend on the order, which numbers decide.
    RC_ASSERT(metrics->at75.f1 == other->at75.f1);
    RC_ASSERT(metrics->false_objects == other->false_objects);
    RC_ASSERT(metrics->over_segmentation == other->over_segmentation);
    RC_ASSERT(metrics->under_segmentation == other->under_segmentation);
    RC_ASSERT(metrics->at75.precision == mirrored->at75.recall);
    RC_ASSERT(metrics->over_segmentation == mirrored->under_segmentation);
    std::uint64_t pixels = 0;
    for (std::size_t i = 0; i < metrics->objects.size(); ++i) {
      RC_ASSERT(metrics->objects[i].iou == other->objects[i].iou);
      pixels += metrics->objects[i].pixels;
    }
    std::uint64_t judged_object_pixels = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (judged[i] != 0 && truth[i] != 0) ++judged_object_pixels;
    }
    RC_ASSERT(pixels == judged_object_pixels);
  });
}

}  // namespace
}  // namespace fransac::eval

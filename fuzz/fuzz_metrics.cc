// SPDX-License-Identifier: Apache-2.0
// Metrics of any two images of labels and any objects: counts that add up, shares from 0 to 1, and of an image with itself the
// best; sizes and options that do not fit are errors.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "draw.hpp"
#include "fransac/eval/hoover.hpp"
#include "fransac/eval/metrics.hpp"
#include "require.hpp"

namespace {

using namespace fransac;
using namespace fransac::eval;
using namespace fransac::fuzz;
using Labels = std::vector<std::uint8_t>;

bool is_share(double value) { return value >= 0.0 && value <= 1.0 + 1e-12; }

void check(const Detection& d, std::size_t size) {
  require(d.true_positives + d.false_positives + d.false_negatives <= size);
  require(is_share(d.precision()) && is_share(d.recall()) && is_share(d.f1()));
}

void check(const InstanceMetrics::AtIou& at) {
  require(at.matched >= 0 && at.false_positives >= 0);
  require(is_share(at.precision) && is_share(at.recall) && is_share(at.f1) && is_share(at.mean_iou));
}

void check_planes(const Labels& truth, const Labels& predicted, double min_share) {
  const auto one = dominant_plane(truth, predicted);
  const auto best = best_overlap(truth, predicted);
  const auto matched = matched_plane(truth, predicted);
  const auto all = instance_metrics(truth, predicted, min_share);
  const bool fits = truth.size() == predicted.size();
  require(one.ok() == fits && best.ok() == fits && matched.ok() == fits && (fits || !all));
  if (!fits) return require_message(one.error());
  check(*one, truth.size());
  check(best->detection, truth.size());
  check(matched->detection, truth.size());
  require(all.ok() == is_share(min_share));
  if (!all) return require_message(all.error());
  check(all->at50);
  check(all->at75);
  require(all->at75.matched <= all->at50.matched && all->at50.matched <= std::min(all->true_planes, all->predicted_planes));
  for (const double share :
       {all->under_segmentation, all->over_segmentation, all->missed, all->noise, all->weighted_iou, all->plane_pixel_f1}) {
    require(is_share(share));
  }
  const auto self = instance_metrics(truth, truth, min_share);
  require(self && self->at75.matched == self->true_planes && self->missed == 0.0);
}

void check_regions(Bytes& bytes, const Labels& truth, const Labels& predicted) {
  HooverOptions options;
  options.truth = bytes.ConsumeBool() ? TrueRegions::segcomp : TrueRegions::labels;
  options.min_pixels = draw_seldom(bytes) ? bytes.ConsumeIntegral<int>() : bytes.ConsumeIntegralInRange(1, 20);
  const int width = draw_seldom(bytes) ? bytes.ConsumeIntegral<int>() : bytes.ConsumeIntegralInRange(1, 16);
  const double tolerance = draw_seldom(bytes) ? draw_any(bytes) : 0.51 + draw_number(bytes, 0.0, 0.49);
  const auto found = hoover(truth, predicted, width, tolerance, options);
  if (!found) return require_message(found.error());
  require(truth.size() == predicted.size() && tolerance > 0.5 && tolerance <= 1.0 && options.min_pixels >= 1);
  require(found->correct + found->over_segmented + found->missed <= found->true_regions);
  require(found->correct + found->under_segmented + found->noise <= found->predicted);
  require(std::min({found->correct, found->over_segmented, found->under_segmented, found->missed, found->noise}) >= 0);
}

void check_objects(const std::vector<std::uint16_t>& truth, const std::vector<std::uint16_t>& predicted, const Labels& judged) {
  const auto found = object_metrics(truth, predicted, judged);
  require(found.ok() == (truth.size() == predicted.size() && truth.size() == judged.size()));
  if (!found) return require_message(found.error());
  check(found->at50);
  check(found->at75);
  require(is_share(found->under_segmentation) && is_share(found->over_segmentation));
  require(found->false_objects >= 0 && found->false_objects <= found->predicted_objects);
  require(found->objects.size() == static_cast<std::size_t>(found->true_objects));
  for (const ObjectMetrics::Object& object : found->objects) require(object.id > 0 && object.pixels > 0 && is_share(object.iou));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  const std::size_t pixels = bytes.ConsumeIntegralInRange<std::size_t>(0, 256);
  const std::uint8_t most = bytes.ConsumeBool() ? 3 : 255;  // few labels make large regions
  const auto draw = [&](auto none) {
    using Label = decltype(none);
    std::vector<Label> labels(pixels + (draw_seldom(bytes) ? 1 : 0), none);
    for (Label& label : labels) label = bytes.ConsumeIntegralInRange<Label>(0, most);
    return labels;
  };
  const Labels truth = draw(std::uint8_t{});
  const Labels predicted = draw(std::uint8_t{});
  check_planes(truth, predicted, draw_seldom(bytes) ? draw_any(bytes) : draw_number(bytes, 0.0, 1.0));
  check_regions(bytes, truth, predicted);
  const auto floor = floor_as_obstacle(truth, draw(std::uint16_t{}), 1);
  require(!floor || (floor->obstacle <= floor->floor && is_share(floor->share())));
  check_objects(draw(std::uint16_t{}), draw(std::uint16_t{}), truth);
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
#include "../geometry_json.hpp"
#include "../obstacle_output.hpp"
#include "fransac/version.hpp"
#include "writers.hpp"

namespace fransac::cli {
namespace {

/// A value, or null where it is unknown.
template <class Value>
nlohmann::ordered_json known(bool is_known, const Value& value) {
  return is_known ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

nlohmann::ordered_json evidence_to_json(const PlaneEvidence& evidence) {
  return {{"share", evidence.share},
          {"turn_rad", evidence.turn_rad},
          {"turn_sigma_rad", evidence.turn_sigma_rad},
          {"smooth_border", evidence.smooth_border}};
}

nlohmann::ordered_json plane_to_json(const PlaneSegment& segment, Method method) {
  const bool cells = method == Method::cells;  // the others know no evidence and no covariance
  return {{"id", segment.id},
          {"normal", vector_to_json(segment.plane.normal)},
          {"d", segment.plane.d},
          {"inliers", segment.inliers},
          {"support", segment.support},
          {"rms_m", segment.rms_m},
          {"area_m2", segment.area_m2},
          {"confidence", segment.confidence},
          {"evidence", cells ? evidence_to_json(segment.evidence) : nullptr},
          {"centroid", segment.centroid.isZero(0.0) ? nullptr : vector_to_json(segment.centroid)},
          {"kind", enum_name(segment.kind)},
          {"covariance", cells ? matrix_to_json(segment.covariance) : nullptr},
          {"iterations", known(!cells, segment.iterations)},
          {"stop_reason", known(!cells, to_string(segment.stop_reason))}};
}

nlohmann::ordered_json noise_to_json(const DepthNoise& noise) {
  return {{"constant_m", noise.constant_m}, {"linear", noise.linear}, {"quadratic_per_m", noise.quadratic_per_m}};
}

nlohmann::ordered_json timing_to_json(const Timing& timing) {
  nlohmann::ordered_json json;
  for (std::size_t stage = 0; stage < timing.stage_ms.size(); ++stage) {
    json[std::string(EnumNames<Stage>::values[stage])] = timing.stage_ms[stage];
  }
  json["total"] = timing.total_ms;
  return json;
}

nlohmann::ordered_json planes_to_json(const SegmentRequest& request, const SegmentResult& result) {
  nlohmann::ordered_json planes = nlohmann::ordered_json::array();
  for (const PlaneSegment& plane : result.segmentation.planes) planes.push_back(plane_to_json(plane, result.segmentation.method));
  for (std::size_t p = 0; request.outlines && p < planes.size(); ++p) {
    planes[p]["outlines"] = outlines_to_json(result.outlines[p]);
  }
  return planes;
}

}  // namespace

nlohmann::ordered_json to_json(const SegmentRequest& request, const SegmentResult& result) {
  const Segmentation& found = result.segmentation;
  const bool cells = found.method == Method::cells;  // the others know no errors of the sensor, cells no samples
  nlohmann::ordered_json json;
  json["input"] = result.name;
  if (result.frame) json["frame"] = *result.frame;
  json["method"] = enum_name(found.method);
  json["seed"] = request.options.seed;
  json["width"] = found.width;
  json["height"] = found.height;
  json["planes"] = planes_to_json(request, result);
  if (result.obstacles) {
    json["obstacles"] = obstacles_to_json(found, *result.obstacles);
    if (request.outlines) add_outlines(json["obstacles"], *result.obstacles, result.outlines, result.drop_outlines);
  }
  json["up"] = found.up ? vector_to_json(*found.up) : nullptr;
  json["up_source"] = enum_name(found.up_source);
  json["up_sigma_rad"] = known(found.up_source == UpSource::estimated, found.up_sigma_rad);
  json["sensor_position"] = found.sensor_position ? vector_to_json(*found.sensor_position) : nullptr;
  json["noise"] = cells ? noise_to_json(found.noise) : nullptr;
  json["slow_noise"] = cells ? noise_to_json(found.slow_noise) : nullptr;
  json["bias_m"] = known(cells, found.bias_m);
  json["corrected"] = !found.distortion.empty();
  json["iterations"] = known(!cells, found.iterations);
  json["stop_reason"] = known(!cells, to_string(found.stop_reason));
  json["timing_ms"] = timing_to_json(found.timing);
  json["valid_points"] = found.valid_points;
  json["sampled_points"] = found.sampled_points;
  json["rejected"] = known(!cells, found.rejected);
  json["degenerate_samples"] = known(!cells, found.degenerate);
  json["options"] = options_to_json(with_defaults(request.options, found.method));
  if (result.obstacles) json["options"].update(options_to_json(request.obstacles.options));
  json["fransac_version"] = kVersion;
  return json;
}

}  // namespace fransac::cli

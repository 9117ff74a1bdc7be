// SPDX-License-Identifier: Apache-2.0
#include "changed_frames.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <iterator>
#include <type_traits>
#include <utility>

#include "fransac/core/random.hpp"

namespace fransac::testing {
namespace {

constexpr std::uint16_t kMissing = 0;
constexpr std::uint16_t kSaturated = 65535;
constexpr std::uint8_t kIgnored = 0;
constexpr std::size_t kMaxPixels = std::size_t{4096} * 3072;
constexpr std::uint64_t kSeed = 20240229;  // of the holes; any other does
constexpr double kSameSurface = 0.05;      // depths that differ by more lie on two surfaces, of the nearer one's depth

std::size_t pixels_of(const Camera& camera) {
  return static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
}

std::size_t index_of(const Camera& camera, int u, int v) {
  return static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(u);
}

/// Sets `raw`, which is no longer what the surface there would measure.
void overwrite(ChangedFrame& frame, std::size_t i, std::uint16_t raw) {
  frame.depth[i] = raw;
  frame.labels[i] = kIgnored;
}

template <class Predicate>  // of (u, v)
void overwrite_where(ChangedFrame& frame, std::uint16_t raw, Predicate where) {
  for (int v = 0; v < frame.camera.height; ++v) {
    for (int u = 0; u < frame.camera.width; ++u) {
      if (where(u, v)) overwrite(frame, index_of(frame.camera, u, v), raw);
    }
  }
}

void lose_at_random(ChangedFrame& frame, double share) {
  RandomStream random(kSeed, static_cast<std::uint64_t>(std::lround(100.0 * share)));
  overwrite_where(frame, kMissing, [&](int, int) { return random.uniform() < share; });
}

/// Every n-th row and every m-th column; 0: none.
void lose_lines(ChangedFrame& frame, int rows, int columns) {
  overwrite_where(frame, kMissing,
                  [&](int u, int v) { return (rows > 0 && v % rows == 0) || (columns > 0 && u % columns == 0); });
}

enum class Place { upper, lower, left, right, middle };

/// A region of a share of the picture.
void fill(ChangedFrame& frame, Place place, double share, std::uint16_t raw) {
  const Camera& camera = frame.camera;
  const auto part = [&](int side, double of) { return static_cast<int>(std::lround(of * side)); };
  int left = 0;
  int top = 0;
  int right = camera.width;
  int bottom = camera.height;
  switch (place) {
    case Place::upper: bottom = part(camera.height, share); break;
    case Place::lower: top = camera.height - part(camera.height, share); break;
    case Place::left: right = part(camera.width, share); break;
    case Place::right: left = camera.width - part(camera.width, share); break;
    case Place::middle: {
      const int width = part(camera.width, std::sqrt(share));
      const int height = part(camera.height, std::sqrt(share));
      left = (camera.width - width) / 2;
      top = (camera.height - height) / 2;
      right = left + width;
      bottom = top + height;
      break;
    }
  }
  overwrite_where(frame, raw, [&](int u, int v) { return u >= left && u < right && v >= top && v < bottom; });
}

/// False, and nothing done, where the unit cannot hold the value as a measurement.
bool fill_metres(ChangedFrame& frame, Place place, double share, double metres) {
  const double raw = std::round(metres * frame.camera.depth_scale);
  if (raw < 1.0 || raw >= kSaturated) return false;
  fill(frame, place, share, static_cast<std::uint16_t>(raw));
  return true;
}

/// Sets what lies beyond the median of the measured depths to the median, or to the largest of them.
bool clip_far(ChangedFrame& frame, bool to_median) {
  std::vector<std::uint16_t> measured;
  std::copy_if(frame.depth.begin(), frame.depth.end(), std::back_inserter(measured), [](std::uint16_t raw) { return raw != 0; });
  if (measured.empty()) return false;
  const auto middle = measured.begin() + static_cast<std::ptrdiff_t>(measured.size() / 2);
  std::nth_element(measured.begin(), middle, measured.end());
  const std::uint16_t median = *middle;
  const std::uint16_t constant = to_median ? median : *std::max_element(measured.begin(), measured.end());
  for (std::size_t i = 0; i < frame.depth.size(); ++i) {
    if (frame.depth[i] > median) overwrite(frame, i, constant);
  }
  return true;
}

Camera enlarged(Camera camera, int s) {
  camera.width *= s;
  camera.height *= s;
  camera.fx *= s;
  camera.fy *= s;
  camera.cx = s * (camera.cx + 0.5) - 0.5;  // (0, 0) is the centre of a pixel, hence the halves
  camera.cy = s * (camera.cy + 0.5) - 0.5;
  return camera;
}

/// The mean of the four pixels around (x, y), `nearest` of them included, by their distance: of those that were measured on the
/// surface of the nearest. `mixed`: they are not of one label.
std::uint16_t interpolated(const ChangedFrame& frame, double x, double y, std::size_t nearest, bool& mixed) {
  const Camera& camera = frame.camera;
  const int u0 = static_cast<int>(std::floor(x));
  const int v0 = static_cast<int>(std::floor(y));
  const double raw = frame.depth[nearest];
  double sum = 0.0;
  double weights = 0.0;
  for (const int v : {v0, v0 + 1}) {
    for (const int u : {u0, u0 + 1}) {
      if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) continue;
      const std::size_t i = index_of(camera, u, v);
      const double weight = (1.0 - std::abs(x - u)) * (1.0 - std::abs(y - v));
      if (frame.depth[i] == kMissing || weight <= 0.0) continue;
      const double other = frame.depth[i];
      if (std::abs(other - raw) > kSameSurface * std::min(other, raw)) continue;
      sum += weight * other;
      weights += weight;
      if (frame.labels[i] != frame.labels[nearest]) mixed = true;
    }
  }
  return static_cast<std::uint16_t>(std::lround(sum / weights));
}

bool enlarge(ChangedFrame& frame, int s, bool bilinear) {
  ChangedFrame result;
  result.kind = frame.kind;
  result.camera = enlarged(frame.camera, s);
  const std::size_t pixels = pixels_of(result.camera);
  if (pixels > kMaxPixels) return false;
  result.depth.resize(pixels);
  result.labels.resize(pixels);
  result.source.resize(pixels);
  std::size_t i = 0;
  for (int v = 0; v < result.camera.height; ++v) {
    for (int u = 0; u < result.camera.width; ++u, ++i) {
      const std::size_t nearest = index_of(frame.camera, u / s, v / s);
      result.depth[i] = frame.depth[nearest];
      result.labels[i] = frame.labels[nearest];
      result.source[i] = frame.source[nearest];
      if (!bilinear || frame.depth[nearest] == kMissing) continue;
      bool mixed = false;
      result.depth[i] = interpolated(frame, (u + 0.5) / s - 0.5, (v + 0.5) / s - 0.5, nearest, mixed);
      if (mixed) result.labels[i] = kIgnored;
    }
  }
  frame = std::move(result);
  return true;
}

/// Keeps every n-th pixel of every n-th row, the first one included.
void keep_every(ChangedFrame& frame, int n) {
  ChangedFrame result;
  result.kind = frame.kind;
  result.camera = frame.camera;
  result.camera.width = (frame.camera.width + n - 1) / n;
  result.camera.height = (frame.camera.height + n - 1) / n;
  result.camera.fx /= n;
  result.camera.fy /= n;
  result.camera.cx /= n;
  result.camera.cy /= n;
  for (int v = 0; v < frame.camera.height; v += n) {
    for (int u = 0; u < frame.camera.width; u += n) {
      const std::size_t i = index_of(frame.camera, u, v);
      result.depth.push_back(frame.depth[i]);
      result.labels.push_back(frame.labels[i]);
      result.source.push_back(frame.source[i]);
    }
  }
  frame = std::move(result);
}

/// What 16 bits do not hold is missing, and so is what they hold to say that.
void set_raw(ChangedFrame& frame, std::size_t i, double raw) {
  if (raw < 1.0 || raw >= kSaturated) {
    overwrite(frame, i, kMissing);
  } else {
    frame.depth[i] = static_cast<std::uint16_t>(raw);
  }
}

/// Depth in steps, in the frame's own unit. What is rounded to nothing is missing. False where the unit is no finer.
bool round_to(ChangedFrame& frame, double step_m) {
  const double step = step_m * frame.camera.depth_scale;  // raw units
  if (step < 1.5) return false;
  for (std::size_t i = 0; i < frame.depth.size(); ++i) {
    if (frame.depth[i] == kMissing) continue;
    set_raw(frame, i, std::round(std::round(frame.depth[i] / step) * step));
  }
  return true;
}

/// False where that is the frame's unit already.
bool set_unit(ChangedFrame& frame, double depth_scale) {
  const double factor = depth_scale / frame.camera.depth_scale;
  if (factor == 1.0) return false;
  frame.camera.depth_scale = depth_scale;
  for (std::size_t i = 0; i < frame.depth.size(); ++i) {
    if (frame.depth[i] == kMissing) continue;
    set_raw(frame, i, std::round(frame.depth[i] * factor));
  }
  return true;
}

/// In steps of `step_m`; 0: as measured.
void set_float(ChangedFrame& frame, double step_m) {
  frame.metres.reserve(frame.depth.size());
  for (const std::uint16_t raw : frame.depth) {
    const double metres = raw / frame.camera.depth_scale;
    frame.metres.push_back(static_cast<float>(step_m > 0.0 ? step_m * std::round(metres / step_m) : metres));
  }
}

void mirror(ChangedFrame& frame) {
  const std::ptrdiff_t width = frame.camera.width;
  for (std::ptrdiff_t v = 0; v < frame.camera.height; ++v) {
    std::reverse(frame.depth.begin() + v * width, frame.depth.begin() + (v + 1) * width);
    std::reverse(frame.labels.begin() + v * width, frame.labels.begin() + (v + 1) * width);
    std::reverse(frame.source.begin() + v * width, frame.source.begin() + (v + 1) * width);
  }
  frame.camera.cx = frame.camera.width - 1 - frame.camera.cx;
}

/// A change and what does it; false where it means nothing to the frame.
struct Recipe {
  Change change;
  std::function<bool(ChangedFrame&)> apply;
};

class Recipes {
 public:
  /// `apply` returns whether it means something to the frame, or nothing where it always does.
  template <class Function>
  void add(std::string kind, ChangeFamily family, Function apply, int enlargement = 1, int step = 1) {
    Recipe& recipe = list_.emplace_back();
    recipe.change.kind = std::move(kind);
    recipe.change.family = family;
    recipe.change.enlargement = enlargement;
    recipe.change.step = step;
    recipe.apply = [apply](ChangedFrame& frame) {
      if constexpr (std::is_void_v<decltype(apply(frame))>) {
        apply(frame);
        return true;
      } else {
        return apply(frame);
      }
    };
  }

  void add_constant(std::string where, int metres, Place place, double share) {
    add("constant " + std::to_string(metres) + " m, " + where + ' ' + percent(share), ChangeFamily::constant,
        [=](ChangedFrame& f) { return fill_metres(f, place, share, metres); });
  }

  static std::string percent(double share) { return std::to_string(std::lround(100.0 * share)) + " %"; }

  std::vector<Recipe> take() { return std::move(list_); }

 private:
  std::vector<Recipe> list_;
};

std::vector<Recipe> make_recipes() {
  using Family = ChangeFamily;
  Recipes list;
  for (const double share : {0.1, 0.25, 0.4}) {
    list.add("missing " + Recipes::percent(share), Family::missing, [=](ChangedFrame& f) { lose_at_random(f, share); });
  }
  list.add("missing every 8th row", Family::missing, [](ChangedFrame& f) { lose_lines(f, 8, 0); });
  list.add("missing every 2nd row", Family::missing, [](ChangedFrame& f) { lose_lines(f, 2, 0); });
  list.add("missing every 5th row, 7th column", Family::missing, [](ChangedFrame& f) { lose_lines(f, 5, 7); });

  const std::pair<Place, std::string> places[] = {{Place::upper, "upper "}, {Place::left, "left "}, {Place::middle, "middle "}};
  for (const auto& [place, name] : places) {
    for (const double share : {0.1, 0.3, 0.5}) {
      list.add("saturated " + name + Recipes::percent(share), Family::saturated,
               [=, at = place](ChangedFrame& f) { fill(f, at, share, kSaturated); });
    }
  }

  list.add_constant("upper", 8, Place::upper, 0.1);
  list.add_constant("left", 8, Place::left, 0.35);
  list.add_constant("middle", 8, Place::middle, 0.5);
  list.add_constant("middle", 3, Place::middle, 0.1);
  list.add_constant("right", 3, Place::right, 0.35);
  list.add_constant("lower", 3, Place::lower, 0.5);
  list.add("far half at the median", Family::constant, [](ChangedFrame& f) { return clip_far(f, true); });
  list.add("far half at the maximum", Family::constant, [](ChangedFrame& f) { return clip_far(f, false); });

  for (const int s : {2, 4}) {
    for (const bool bilinear : {false, true}) {
      list.add(
          "enlarged by " + std::to_string(s) + (bilinear ? ", bilinear" : ", nearest"), Family::enlarged,
          [=](ChangedFrame& f) { return enlarge(f, s, bilinear); }, s);
    }
  }
  list.add(
      "every 2nd pixel", Family::fewer, [](ChangedFrame& f) { keep_every(f, 2); }, 1, 2);
  list.add(
      "every 4th pixel", Family::fewer, [](ChangedFrame& f) { keep_every(f, 4); }, 1, 4);
  list.add(
      "every 8th pixel", Family::fewer, [](ChangedFrame& f) { keep_every(f, 8); }, 1, 8);

  list.add("step of 0.1 mm, float metres", Family::values, [](ChangedFrame& f) { set_float(f, 1e-4); });
  list.add("step of 1 mm", Family::values, [](ChangedFrame& f) { return round_to(f, 1e-3); });
  list.add("step of 5 mm", Family::values, [](ChangedFrame& f) { return round_to(f, 5e-3); });
  for (const int scale : {1000, 5000, 10000}) {
    list.add("depth scale " + std::to_string(scale), Family::values, [=](ChangedFrame& f) { return set_unit(f, scale); });
  }
  list.add("float metres", Family::values, [](ChangedFrame& f) { set_float(f, 0.0); });

  list.add("mirrored", Family::mirrored, [](ChangedFrame& f) { mirror(f); });

  list.add(
      "every 2nd pixel, missing 25 %", Family::combined,
      [](ChangedFrame& f) {
        keep_every(f, 2);
        lose_at_random(f, 0.25);
      },
      1, 2);
  list.add("saturated left 30 %, missing 10 %", Family::combined, [](ChangedFrame& f) {
    lose_at_random(f, 0.1);
    fill(f, Place::left, 0.3, kSaturated);
  });
  return list.take();
}

const std::vector<Recipe>& recipes() {
  static const std::vector<Recipe> list = make_recipes();
  return list;
}

}  // namespace

DepthView ChangedFrame::view() const {
  return metres.empty() ? DepthView::from_uint16(depth.data(), camera.width, camera.height, camera.depth_scale)
                        : DepthView::from_float(metres.data(), camera.width, camera.height);
}

std::span<const Change> changes() {
  static const std::vector<Change> list = [] {
    std::vector<Change> all;
    for (const Recipe& recipe : recipes()) all.push_back(recipe.change);
    return all;
  }();
  return list;
}

ChangedFrame unchanged_frame(const Camera& camera, std::span<const std::uint16_t> depth, std::span<const std::uint8_t> labels) {
  ChangedFrame frame;
  frame.kind = "unchanged";
  frame.camera = camera;
  frame.depth.assign(depth.begin(), depth.end());
  frame.labels.assign(labels.begin(), labels.end());
  frame.source.resize(pixels_of(camera));
  for (std::size_t i = 0; i < frame.source.size(); ++i) frame.source[i] = static_cast<std::uint32_t>(i);
  return frame;
}

ChangedFrame changed_frame(const Change& change, const Camera& camera, std::span<const std::uint16_t> depth,
                           std::span<const std::uint8_t> labels) {
  const auto recipe =
      std::find_if(recipes().begin(), recipes().end(), [&](const Recipe& r) { return r.change.kind == change.kind; });
  if (recipe == recipes().end()) return {};
  ChangedFrame frame = unchanged_frame(camera, depth, labels);
  frame.kind = change.kind;
  if (!recipe->apply(frame)) return {};
  return frame;
}

std::vector<ChangedFrame> changed_frames(const Camera& camera, std::span<const std::uint16_t> depth,
                                         std::span<const std::uint8_t> labels) {
  std::vector<ChangedFrame> list;
  for (const Change& change : changes()) {
    ChangedFrame frame = changed_frame(change, camera, depth, labels);
    if (!frame.depth.empty()) list.push_back(std::move(frame));
  }
  return list;
}

}  // namespace fransac::testing

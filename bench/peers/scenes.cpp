// SPDX-License-Identifier: Apache-2.0
#include "scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "errors.hpp"
#include "fransac/core/labels.hpp"
#include "fransac/core/random.hpp"
#include "fransac/planes/segment.hpp"
#include "fransac/synth/synth.hpp"

namespace fransac::bench {
namespace {

/// The plane that the labelling floor labels: any that is really there.
void find_plane(Scene& scene) {
  const DepthView view =
      DepthView::from_uint16(scene.depth.data(), scene.camera.width, scene.camera.height, scene.camera.depth_scale);
  SegmentOptions options;
  options.method = Method::fransac;
  const Result<Segmentation> found = segment(view, scene.camera, options);
  if (!found || found->planes.empty()) return;
  const Plane& plane = found->planes.front().plane;
  for (int i = 0; i < 3; ++i) scene.plane[i] = plane.normal[i];
  scene.plane[3] = plane.d;
}

Scene render(std::string name, const synth::SynthOptions& options) {
  synth::SynthFrame frame = cli::unwrap(synth::render(options));
  Scene scene;
  scene.dataset = "synth";
  scene.name = std::move(name);
  scene.camera = frame.camera;
  scene.depth = std::move(frame.depth);
  scene.truth = std::move(frame.labels);
  scene.objects = std::move(frame.objects);
  scene.all_planes = true;
  find_plane(scene);
  return scene;
}

}  // namespace

Frame Scene::frame() const {
  Frame frame{camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy, camera.depth_scale, nullptr, nullptr, {}};
  if (depth.empty()) {
    frame.points = points.data();
  } else {
    frame.depth = depth.data();
  }
  std::copy(std::begin(plane), std::end(plane), std::begin(frame.plane));
  return frame;
}

std::vector<Scene> load_dataset(const std::filesystem::path& folder, std::size_t max_frames) {
  const io::Dataset dataset = cli::unwrap(io::list_frames(folder));
  std::vector<Scene> scenes;
  for (const io::FrameFiles& files : dataset.frames) {
    if (max_frames > 0 && scenes.size() == max_frames) break;
    io::Frame frame = cli::unwrap(io::load_frame(files));
    Scene scene;
    scene.dataset = dataset.name;
    scene.name = frame.name;
    scene.camera = frame.camera;
    scene.depth = std::move(frame.depth.pixels);
    if (frame.labels) scene.truth = std::move(frame.labels->pixels);
    if (frame.objects) scene.objects = std::move(frame.objects->pixels);
    scene.dominant = dataset.truth == io::Truth::dominant;
    scene.all_planes = dataset.truth == io::Truth::planes;
    find_plane(scene);
    scenes.push_back(std::move(scene));
  }
  return scenes;
}

std::vector<Scene> synth_dataset(std::size_t max_frames) {
  std::vector<Scene> scenes;
  for (std::uint64_t seed = 0; seed < 2; ++seed) {
    for (const std::string_view name : synth::scene_names()) {
      if (max_frames > 0 && scenes.size() == max_frames) return scenes;
      synth::SynthOptions options;
      options.scene = name;
      options.seed = seed;
      scenes.push_back(render(fmt::format("{}-{}", name, seed), options));
    }
  }
  return scenes;
}

Scene synth_desk(int width, int height) {
  synth::SynthOptions options;
  const double zoom = width / 640.0;
  options.camera.width = width;
  options.camera.height = height;
  options.camera.fx *= zoom;
  options.camera.fy *= zoom;
  options.camera.cx = (width - 1) / 2.0;
  options.camera.cy = (height - 1) / 2.0;
  return render(fmt::format("{}x{}", width, height), options);
}

std::vector<Scene> synth_resolutions() {
  constexpr std::pair<int, int> kSizes[] = {{80, 60}, {160, 120}, {320, 240}, {640, 480}, {1280, 960}, {1920, 1080}};
  std::vector<Scene> scenes;
  for (const auto& [width, height] : kSizes) scenes.push_back(synth_desk(width, height));
  return scenes;
}

Scene synth_cloud(std::size_t points) {
  constexpr double kWidth_m = 4.0;
  constexpr double kHeight_m = 2.5;
  constexpr double kNoise_m = 0.003;
  Scene scene;
  scene.dataset = "synth";
  scene.name = fmt::format("{}", points);
  scene.camera.width = static_cast<int>(points);
  scene.camera.height = 1;
  scene.dominant = true;
  scene.points.reserve(3 * points);
  scene.truth.reserve(points);
  struct Ball {
    Eigen::Vector3d centre;
    double radius;
  };
  RandomStream random(0, 0);
  std::vector<Ball> balls(60);
  for (Ball& ball : balls) {
    ball.centre.x() = (random.uniform() - 0.5) * kWidth_m;
    ball.centre.y() = (random.uniform() - 0.5) * kWidth_m;
    ball.centre.z() = random.uniform() * kHeight_m;
    ball.radius = 0.1 + 0.1 * random.uniform();
  }
  const auto add = [&scene](const Eigen::Vector3d& point, std::uint8_t label) {
    for (int i = 0; i < 3; ++i) scene.points.push_back(static_cast<float>(point[i]));
    scene.truth.push_back(label);
  };
  for (std::size_t i = 0; i < points; ++i) {
    const double kind = random.uniform();
    const double noise = kNoise_m * random.normal();
    if (kind < 0.6) {
      const double x = (random.uniform() - 0.5) * kWidth_m;
      add({x, (random.uniform() - 0.5) * kWidth_m, noise}, kLabelFirst);
    } else if (kind < 0.8) {
      const double y = (random.uniform() - 0.5) * kWidth_m;
      add({kWidth_m / 2 + noise, y, random.uniform() * kHeight_m}, kLabelFirst + 1);
    } else {
      const Ball& ball = balls[random.below(static_cast<std::uint32_t>(balls.size()))];
      Eigen::Vector3d direction;
      for (int axis = 0; axis < 3; ++axis) direction[axis] = random.normal();
      add(ball.centre + (ball.radius + noise) * direction.normalized(), kLabelNoPlane);
    }
  }
  return scene;
}

}  // namespace fransac::bench

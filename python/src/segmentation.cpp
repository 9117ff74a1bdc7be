// SPDX-License-Identifier: Apache-2.0
#include "segmentation.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "archive.hpp"
#include "bindings.hpp"
#include "camera.hpp"
#include "fransac/io/image.hpp"
#include "fransac/io/overlay.hpp"
#include "options.hpp"

namespace fransac::python {
namespace {

/// Results that Python has let go of. Never destroyed: arrays can outlive everything at exit.
class Pool {
 public:
  static Pool& instance() {
    static Pool& pool = *new Pool;
    return pool;
  }
  std::unique_ptr<Found> take() {
    const std::lock_guard lock(mutex_);
    if (idle_.empty()) return std::make_unique<Found>();
    std::unique_ptr<Found> found = std::move(idle_.back());
    idle_.pop_back();
    return found;
  }
  void give(std::unique_ptr<Found> found) noexcept try {
    const std::lock_guard lock(mutex_);
    if (idle_.size() < kMostIdle) idle_.push_back(std::move(found));
  } catch (...) {  // no memory to remember it in: it is freed instead
  }

 private:
  static constexpr std::size_t kMostIdle = 4;  // a loop holds one result while it computes the next; a few such loops
  std::mutex mutex_;
  std::vector<std::unique_ptr<Found>> idle_;
};

/// What a thread keeps from call to call.
struct Work {
  Workspace planes;
  ObstacleWorkspace obstacles;
  DepthBuffer depth;
  PointCloud cloud;
};
Work& work_of_thread() {
  thread_local Work work;
  return work;
}

const Keywords<SegmentOptions>& segment_keywords() {
  static const auto& keywords = *new Keywords<SegmentOptions>({}, {"method"});
  return keywords;
}
const Keywords<ObstacleOptions>& obstacle_keywords() {
  static const auto& keywords = *new Keywords<ObstacleOptions>();
  return keywords;
}

/// The options of a call.
struct Request {
  SegmentOptions options;
  ObstacleOptions obstacle_options;
  bool obstacles = false;
};

/// `used`: keyword arguments that the caller has read already.
Request read_request(const char* function, nb::handle method, nb::handle obstacles, const nb::kwargs& kwargs, std::size_t used,
                     bool with_camera) {
  Request request;
  read_value("method", method, request.options.method);
  read_value("obstacles", obstacles, request.obstacles);
  used += segment_keywords().read(kwargs, request.options);
  const std::size_t of_obstacles = obstacle_keywords().read(kwargs, request.obstacle_options);
  if (used + of_obstacles != kwargs.size()) {
    const auto& segment = segment_keywords().list();
    const auto& obstacle = obstacle_keywords().list();
    if (!with_camera) reject_unknown(function, kwargs, {&segment, &obstacle}, {"method", "obstacles"});
    reject_unknown(function, kwargs, {&segment, &obstacle},
                   {"method", "obstacles", "camera", "fx", "fy", "cx", "cy", "depth_scale"});
  }
  check(validate(request.options));
  if (of_obstacles > 0 && !request.obstacles) {
    for (const Keyword& keyword : obstacle_keywords().list()) {
      if (kwargs.contains(keyword.name.c_str())) raise_value_error(keyword.name + ": needs obstacles=True");
    }
  }
  if (request.obstacles) check(validate(request.obstacle_options));
  return request;
}

Camera camera_of_call(nb::handle camera, const nb::kwargs& kwargs, int width, int height, std::size_t& used) {
  if (camera.is_none()) return read_camera_keywords("segment", kwargs, width, height, used);
  for (const char* const name : kCameraKeywords) {
    if (kwargs.size() > 0 && kwargs.contains(name)) raise_type_error(std::string("camera: given, and so is ") + name);
  }
  return read_camera(camera, width, height);
}

/// Planes, then obstacles, of a depth image.
Status find(const DepthView& depth, const Request& request, Work& work, Found& found) {
  Status status = fransac::segment(depth, *found.camera, request.options, work.planes, found.planes);
  if (!status || !request.obstacles) return status;
  const AxisLimits* const limits = limits_of(request.options, found.planes.method, true);
  return find_obstacles(depth, *found.camera, found.planes, request.obstacle_options, limits, work.obstacles, found.obstacles);
}

Status find(const PointCloud& cloud, const Request& request, Work& work, Found& found) {
  Status status = fransac::segment(cloud, request.options, work.planes, found.planes);
  if (!status || !request.obstacles) return status;
  const AxisLimits* const limits = limits_of(request.options, found.planes.method, found.planes.method == Method::cells);
  Result<Obstacles> obstacles = find_obstacles(cloud, found.planes, request.obstacle_options, limits);
  if (!obstacles) return obstacles.error();
  found.obstacles = std::move(obstacles).value();
  return {};
}

/// Why there is no support, and what to try; empty where there is one.
std::string note_on(const Obstacles& found) {
  if (!found.support.empty()) return {};
  const char* const advice = found.support_reason == SupportReason::up_unknown ? ": try up" : "";
  return "no support for obstacles: " + std::string(reason_text(found.support_reason)) + advice +
         "; all that is seen is an obstacle";
}

/// Why there is no plane, and what to try; empty where there are.
std::string note_on(const fransac::Segmentation& found, const SegmentOptions& asked) {
  if (!found.planes.empty()) return {};
  const SegmentOptions options = with_defaults(asked, found.method);
  const auto number = [](double value) { return std::string(nb::str(nb::float_(value)).c_str()); };
  const bool cells = found.method == Method::cells;  // it knows no threshold
  std::string note = "no plane has the minimum support, " + number(*options.min_support) + " of the " +
                     std::to_string(found.sampled_points) + " sampled points; try " +
                     (cells ? "" : "a larger threshold (now " + number(options.ransac.threshold_m) + " m) or ") +
                     "a smaller min_support";
  std::string limits;
  const auto add = [&limits](bool chosen, const char* name) {
    if (chosen) limits += (limits.empty() ? "" : ", ") + std::string(name);
  };
  add(options.cells.parallel_to.has_value(), "parallel_to");
  add(options.cells.perpendicular_to.has_value(), "perpendicular_to");
  add(options.cells.min_area_m2 > 0.0, "min_area");
  add(options.cells.min_confidence > CellsOptions{}.min_confidence, "min_confidence");
  return limits.empty() ? note : note + "; " + limits + " may have left planes out";
}

std::string note_on(const Found& found, const SegmentOptions& asked) {
  const std::string planes = note_on(found.planes, asked);
  const std::string support = found.obstacles_asked ? note_on(found.obstacles) : "";
  return planes + (planes.empty() || support.empty() ? "" : "; ") + support;
}

PySegmentation segment_depth(nb::handle given_depth, nb::handle given_camera, nb::handle method, nb::handle obstacles,
                             const nb::kwargs& kwargs) {
  const DepthInput depth("depth", given_depth);
  std::size_t used = 0;
  const Camera camera = camera_of_call(given_camera, kwargs, depth.width(), depth.height(), used);
  const Request request = read_request("segment", method, obstacles, kwargs, used, true);
  PySegmentation result;
  Found& found = result.found();
  found.obstacles_asked = request.obstacles;
  found.camera = camera;
  found.shape = {static_cast<std::size_t>(depth.height()), static_cast<std::size_t>(depth.width())};
  Status status;
  {
    const nb::gil_scoped_release release;
    Work& work = work_of_thread();
    status = find(depth.view(camera.depth_scale, work.depth), request, work, found);
  }
  check(status);
  found.note = note_on(found, request.options);
  return result;
}

PySegmentation segment_cloud(nb::handle given_points, nb::handle method, nb::handle obstacles, const nb::kwargs& kwargs) {
  const PointsInput points("points", given_points);
  const Request request = read_request("segment_cloud", method, obstacles, kwargs, 0, false);
  PySegmentation result;
  Found& found = result.found();
  found.obstacles_asked = request.obstacles;
  found.camera.reset();
  found.shape = points.shape();
  Status status;
  {
    const nb::gil_scoped_release release;
    Work& work = work_of_thread();
    points.load(work.cloud);
    status = find(work.cloud, request, work, found);
  }
  check(status);
  found.note = note_on(found, request.options);
  return result;
}

/// Milliseconds of each of `repeat` calls of the library itself, for measuring what a call from Python adds.
std::vector<double> time_in_cpp(nb::handle given_depth, const Camera& camera, int repeat) {
  const DepthInput depth("depth", given_depth);
  DepthBuffer buffer;
  const DepthView view = depth.view(camera.depth_scale, buffer);
  std::vector<double> times;
  Workspace workspace;
  fransac::Segmentation segmentation;
  for (int i = 0; i < repeat; ++i) {
    const auto start = std::chrono::steady_clock::now();
    check(fransac::segment(view, camera, SegmentOptions{}, workspace, segmentation));
    times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  return times;
}

nb::dict timing_of(const Found& found) {
  nb::dict dict;
  for (int i = 0; i < kStages; ++i) {
    const double ms = found.planes.timing.stage_ms[static_cast<std::size_t>(i)];
    if (ms > 0.0) dict[EnumNames<Stage>::values[i].data()] = ms;
  }
  if (found.obstacles_asked) dict["obstacles"] = found.obstacles.total_ms;
  dict["total"] = found.planes.timing.total_ms + (found.obstacles_asked ? found.obstacles.total_ms : 0.0);
  return dict;
}

nb::object noise_of(const Found& found, const DepthNoise& noise) {
  if (found.planes.method != Method::cells) return nb::none();
  nb::dict dict;
  dict["constant_m"] = noise.constant_m;
  dict["linear"] = noise.linear;
  dict["quadratic_per_m"] = noise.quadratic_per_m;
  return dict;
}

template <class Enum>
nb::str word(Enum value) {
  const std::string_view name = enum_name(value);
  return nb::str(name.data(), name.size());
}

/// Colours of the planes, or planes over the picture that `overlay` makes of a depth image or a colour picture.
io::ColourImage picture_of(const Found& found, nb::handle given_depth, nb::handle given_colour) {
  if (!found.camera) raise_value_error("picture: a point cloud has none");
  const int width = found.planes.width;
  const int height = found.planes.height;
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  io::ColourImage colour;
  if (!given_colour.is_none()) {
    const Array array = import_array("colour", given_colour, "an array of shape (H, W, 3) of uint8");
    nb::ndarray<const std::uint8_t, nb::ndim<3>, nb::c_contig, nb::device::cpu> rgb;
    const bool fits = nb::try_cast(given_colour, rgb, false) && rgb.shape(2) == 3 && array.size() == 3 * pixels &&
                      rgb.shape(1) == static_cast<std::size_t>(width);
    if (!fits) raise_value_error("colour: expected a contiguous uint8 array of the labels' (H, W, 3), got " + shape_text(array));
    colour = {width, height, 3, {rgb.data(), rgb.data() + array.size()}};
  }
  if (given_depth.is_none()) {
    // Flat grey where something was measured, at one metre.
    std::vector<float> flat(pixels);
    for (std::size_t i = 0; i < pixels; ++i) flat[i] = found.planes.labels[i] == kLabelNoDepth ? 0.0F : 1.0F;
    return io::overlay(DepthView::from_float(flat.data(), width, height), found.planes.labels,
                       colour.pixels.empty() ? nullptr : &colour);
  }
  const DepthInput depth("depth", given_depth);
  if (depth.width() != width || depth.height() != height) raise_value_error("depth: not the size of the labels");
  DepthBuffer buffer;
  return io::overlay(depth.view(found.camera->depth_scale, buffer), found.planes.labels,
                     colour.pixels.empty() ? nullptr : &colour);
}

nb::bytes png_of(const io::ColourImage& image) {
  const std::vector<std::byte> png = unwrap(io::encode_png(image));
  return nb::bytes(png.data(), png.size());
}

}  // namespace

// Not in the unnamed namespace: templates of archive.hpp look for them by their arguments.

template <class Archive>
void archive(Archive& a, Plane& plane) {
  archive_all(a, plane.normal, plane.d);
}
template <class Archive>
void archive(Archive& a, PlaneEvidence& e) {
  archive_all(a, e.share, e.turn_rad, e.turn_sigma_rad, e.smooth_border);
}
template <class Archive>
void archive(Archive& a, PlaneSegment& p) {
  archive_all(a, p.id, p.plane, p.inliers, p.support, p.iterations, p.stop_reason, p.rms_m, p.centroid, p.covariance, p.kind,
              p.confidence, p.evidence, p.area_m2);
}
template <class Archive>
void archive(Archive& a, DepthNoise& noise) {
  archive_all(a, noise.constant_m, noise.linear, noise.quadratic_per_m);
}
template <class Archive>
void archive(Archive& a, Distortion& d) {
  archive_all(a, d.width, d.height, d.offset_per_m, d.gain);
}
template <class Archive>
void archive(Archive& a, fransac::Segmentation& s) {
  archive_all(a, s.method, s.width, s.height, s.labels, s.residuals_m, s.up, s.up_source, s.up_sigma_rad, s.sensor_position,
              s.noise, s.slow_noise, s.bias_m, s.distortion, s.saturated, s.planes, s.valid_points, s.sampled_points,
              s.iterations, s.rejected, s.degenerate, s.stop_reason, s.timing.stage_ms, s.timing.total_ms);
}
template <class Archive>
void archive(Archive& a, UprightBox& box) {
  archive_all(a, box.centre, box.size, box.yaw_rad);
}
template <class Archive>
void archive(Archive& a, Obstacle& o) {
  archive_all(a, o.id, o.kind, o.pixels, o.centroid, o.box, o.min_height_m, o.max_height_m, o.nearest_m, o.contact, o.planes);
}
template <class Archive>
void archive(Archive& a, Obstacles& o) {
  archive_all(a, o.support, o.support_reason, o.support_doubt, o.ground.origin, o.ground.axes, o.support_plane, o.width, o.height,
              o.labels, o.obstacles, o.total_ms);
}
template <class Archive>
void archive(Archive& a, Camera& c) {
  archive_all(a, c.width, c.height, c.fx, c.fy, c.cx, c.cy, c.depth_scale);
}
template <class Archive>
void archive(Archive& a, Found& found) {
  archive_all(a, found.planes, found.obstacles_asked, found.camera, found.shape, found.note);
  if (found.obstacles_asked) archive(a, found.obstacles);  // else they are what an earlier result left
}

namespace {

/// pickle and copy keep a value's state.
template <class T>
void bind_state(nb::class_<T>& type) {
  type.def("__getstate__", [](const T& self) { return saved(self); });
  type.def("__setstate__", [](T& self, const nb::bytes& state) { new (&self) T(loaded<T>(state)); });
}

/// A state that does not hang together must not be read beyond its arrays.
bool hangs_together(const Found& found) {
  std::size_t size = 1;
  for (const std::size_t side : found.shape) size *= side;
  const auto fits = [size](std::size_t other) { return other == 0 || other == size; };
  return !found.shape.empty() && found.planes.labels.size() == size && fits(found.planes.residuals_m.size()) &&
         fits(found.obstacles.labels.size()) &&
         (!found.camera || (found.planes.width == found.camera->width && found.planes.height == found.camera->height)) &&
         static_cast<std::size_t>(std::max(found.planes.width, 0)) * static_cast<std::size_t>(std::max(found.planes.height, 0)) ==
             size;
}

template <class Item>
nb::list list_of(const std::vector<Item>& items) {
  nb::list list;
  for (const Item& item : items) list.append(nb::cast(item, nb::rv_policy::copy));
  return list;
}

void bind_evidence(nb::module_& m) {
  nb::class_<PlaneEvidence> type(m, "PlaneEvidence",
                                 "What cells saw of a plane when it judged it: what its confidence follows from.");
  type.def_ro("share", &PlaneEvidence::share, "Of the measured pixels, 0 to 1.")
      .def_ro(
          "turn_rad", &PlaneEvidence::turn_rad,
          "By how much the surface's normal turns from end to end, radians: with or without its border, which is blurred; the "
          "lesser.")
      .def_ro("turn_sigma_rad", &PlaneEvidence::turn_sigma_rad, "One sigma of turn_rad, radians.")
      .def_ro("smooth_border", &PlaneEvidence::smooth_border,
              "Share of the border beyond which the surface goes on smoothly, 0 to 1.");
  bind_state(type);
}

void bind_plane(nb::module_& m) {
  nb::class_<PlaneSegment> type(m, "Plane", "A plane of a segmentation: the points p with normal . p + d = 0, metres.");
  type.def_ro("id", &PlaneSegment::id, "Its label, from 1.")
      .def_prop_ro(
          "normal", [](const PlaneSegment& p) { return to_numpy(p.plane.normal); },
          nb::sig("def normal(self) -> " FRANSAC_VECTOR), "Unit normal, shape (3,); the camera is on its side.")
      .def_prop_ro(
          "d", [](const PlaneSegment& p) { return p.plane.d; }, "Distance of the origin, metres, >= 0.")
      .def_prop_ro(
          "coefficients",
          [](const PlaneSegment& p) {
            const Eigen::Vector4d all(p.plane.normal.x(), p.plane.normal.y(), p.plane.normal.z(), p.plane.d);
            return copied_array(all.data(), {4});
          },
          nb::sig("def coefficients(self) -> " FRANSAC_VECTOR), "(normal, d), shape (4,).")
      .def_prop_ro(
          "kind", [](const PlaneSegment& p) { return word(p.kind); }, nb::sig("def kind(self) -> str"),
          "'floor', 'ceiling', 'wall', 'horizontal', 'other', or 'unknown' where nothing tells what is up.")
      .def_ro("inliers", &PlaneSegment::inliers, "Pixels or points with this label.")
      .def_ro("support", &PlaneSegment::support, "Searched points within the threshold when it was found.")
      .def_ro("iterations", &PlaneSegment::iterations, "Hypotheses of the search that found it.")
      .def_prop_ro(
          "stop_reason", [](const PlaneSegment& p) { return nb::str(to_string(p.stop_reason).data()); },
          nb::sig("def stop_reason(self) -> str"), "Why that search ended.")
      .def_ro("rms_m", &PlaneSegment::rms_m, "Root mean square distance of the labelled points, metres.")
      .def_ro("confidence", &PlaneSegment::confidence,
              "Probability that this is a plane of the scene, 0 to 1 (cells; else 1: the other methods do not judge).")
      .def_ro("evidence", &PlaneSegment::evidence, "What that follows from (cells; else zero).")
      .def_ro("area_m2", &PlaneSegment::area_m2, "Visible area, square metres.")
      .def_prop_ro(
          "centroid", [](const PlaneSegment& p) { return to_numpy(p.centroid); },
          nb::sig("def centroid(self) -> " FRANSAC_VECTOR),
          "Of the labelled points, metres, shape (3,) (cells, clouds; else zero).")
      .def_prop_ro(
          "covariance", [](const PlaneSegment& p) { return to_numpy(Eigen::Matrix4d(p.covariance)); },
          nb::sig("def covariance(self) -> " FRANSAC_VECTOR), "Of (normal, d), shape (4, 4), rank 3 (cells; else zero).")
      .def(
          "distance",
          [](const PlaneSegment& p, nb::handle given) {
            const PointsInput points("points", given);
            PointCloud cloud;
            std::vector<double> distances(Eigen::Index{0});
            points.load(cloud);
            distances.resize(cloud.size());
            for (std::size_t i = 0; i < cloud.size(); ++i) distances[i] = p.plane.signed_distance(cloud.point(i));
            return array_from(std::move(distances), points.shape());
          },
          nb::arg("points").none(), nb::sig("def distance(self, points: numpy.typing.NDArray[typing.Any]) -> " FRANSAC_VECTOR),
          "Signed distances of points, (N, 3) or (H, W, 3), in metres, positive on the camera's side; NaN where a point is not "
          "finite.")
      .def(
          "__repr__", [](nb::handle self) { return nb::module_::import_("fransac._display").attr("plane")(self); },
          nb::sig("def __repr__(self) -> str"));
  bind_state(type);
}

void bind_obstacle(nb::module_& m) {
  nb::class_<UprightBox> box(m, "Box", "A box that stands upright on the support, in the ground frame.");
  box.def_prop_ro(
         "centre", [](const UprightBox& b) { return to_numpy(b.centre); }, nb::sig("def centre(self) -> " FRANSAC_VECTOR),
         "x ahead, y left, z up from the camera's foot, metres, shape (3,).")
      .def_prop_ro(
          "size", [](const UprightBox& b) { return to_numpy(b.size); }, nb::sig("def size(self) -> " FRANSAC_VECTOR),
          "Length >= width, height; metres, shape (3,).")
      .def_ro("yaw_rad", &UprightBox::yaw_rad, "Of the length against the ground's x, in (-pi/2, pi/2].");
  bind_state(box);
  nb::class_<Obstacle> obstacle(m, "Obstacle", "What stands on, hangs above or falls away from the support.");
  obstacle.def_ro("id", &Obstacle::id, "Its number in obstacle_labels, from 1, nearest first.")
      .def_prop_ro(
          "kind", [](const Obstacle& o) { return word(o.kind); }, nb::sig("def kind(self) -> str"),
          "'object'; 'plane', of which one face is all that is seen; 'drop': a hole, a step down.")
      .def_ro("pixels", &Obstacle::pixels, "Pixels or points.")
      .def_prop_ro(
          "centroid", [](const Obstacle& o) { return to_numpy(o.centroid); }, nb::sig("def centroid(self) -> " FRANSAC_VECTOR),
          "Of its points, camera frame, metres, shape (3,).")
      .def_prop_ro(
          "box", [](const Obstacle& o) { return o.box; }, "In the ground frame.")
      .def_ro("min_height_m", &Obstacle::min_height_m, "Its lowest point above the support, metres; negative: below.")
      .def_ro("max_height_m", &Obstacle::max_height_m, "Its highest point above the support, metres.")
      .def_ro("nearest_m", &Obstacle::nearest_m, "Distance of its nearest point from the camera, metres.")
      .def_ro("contact", &Obstacle::contact, "Whether it is seen to come down to the support.")
      .def_ro("planes", &Obstacle::planes, "Labels of the planes that a tenth or more of its pixels are on.")
      .def(
          "__repr__", [](nb::handle self) { return nb::module_::import_("fransac._display").attr("obstacle")(self); },
          nb::sig("def __repr__(self) -> str"));
  bind_state(obstacle);
  nb::class_<GroundFrame>(m, "Ground", "Coordinates on the support: the camera's foot is the origin, z up along its normal.")
      .def_prop_ro(
          "origin", [](const GroundFrame& g) { return to_numpy(g.origin); }, nb::sig("def origin(self) -> " FRANSAC_VECTOR),
          "In the camera's frame, metres, shape (3,).")
      .def_prop_ro(
          "axes", [](const GroundFrame& g) { return to_numpy(g.axes); }, nb::sig("def axes(self) -> " FRANSAC_VECTOR),
          "Columns: x (ahead), y (left) and z (up) in the camera's frame, shape (3, 3).");
}

nb::object labels_of(nb::handle self) {
  Found& found = nb::cast<PySegmentation&>(self).found();
  return array_of(found.planes.labels.data(), found.shape, self);
}

nb::object obstacle_labels_of(nb::handle self) {
  Found& found = nb::cast<PySegmentation&>(self).found();
  if (!found.obstacles_asked) return nb::none();
  if (found.obstacles.labels.size() != found.planes.labels.size()) found.obstacles.labels.assign(found.planes.labels.size(), 0);
  return array_of(found.obstacles.labels.data(), found.shape, self);
}

nb::object residuals_of(nb::handle self) {
  Found& found = nb::cast<PySegmentation&>(self).found();
  if (found.planes.residuals_m.empty()) return nb::none();
  return array_of(found.planes.residuals_m.data(), found.shape, self);
}

void bind_result(nb::module_& m) {
  using S = PySegmentation;
  nb::class_<S>(m, "Segmentation", "Planes, and obstacles where they were asked for, of a depth image or a point cloud.")
      .def_prop_ro("labels", &labels_of, nb::sig("def labels(self) -> numpy.typing.NDArray[numpy.uint8]"),
                   "One per pixel or point, uint8 of shape (H, W) or (N,): 0 nothing was measured, 1, 2, ... the planes, 255 on "
                   "no plane.\n"
                   "The memory is this result's own; no later call writes to it.")
      .def_prop_ro(
          "planes", [](const S& s) { return list_of(s.found().planes.planes); }, nb::sig("def planes(self) -> list[Plane]"),
          "In the order asked for: planes[i].id == i + 1.")
      .def_prop_ro(
          "obstacles", [](const S& s) { return s.found().obstacles_asked ? list_of(s.found().obstacles.obstacles) : nb::list(); },
          nb::sig("def obstacles(self) -> list[Obstacle]"),
          "Nearest first: obstacles[i].id == i + 1. Empty without obstacles=True.")
      .def_prop_ro("obstacle_labels", &obstacle_labels_of,
                   nb::sig("def obstacle_labels(self) -> numpy.typing.NDArray[numpy.uint16] | None"),
                   "uint16 like labels: 0, or an obstacle's id. None without obstacles=True.")
      .def_prop_ro(
          "support", [](const S& s) { return s.found().obstacles_asked ? s.found().obstacles.support : std::vector<int>(); },
          "Labels of the support's planes, the chosen first; empty: there is none, as support_reason says, and all that is seen "
          "is "
          "an obstacle; or obstacles were not asked for.")
      .def_prop_ro(
          "support_reason",
          [](const S& s) -> nb::object {
            if (!s.found().obstacles_asked) return nb::none();
            return word(s.found().obstacles.support_reason);
          },
          nb::sig("def support_reason(self) -> str | None"),
          "Why this is the support: 'named', 'floor' or 'surface' (that things stand on); or why there is none: 'no_planes', "
          "'no_such_plane', 'up_unknown', 'no_floor' or 'no_level_plane'. None without obstacles=True.")
      .def_prop_ro(
          "support_doubt",
          [](const S& s) -> nb::object {
            const Found& found = s.found();
            if (!found.obstacles_asked || found.obstacles.support_doubt == SupportDoubt::none) return nb::none();
            return word(found.obstacles.support_doubt);
          },
          nb::sig("def support_doubt(self) -> str | None"),
          "What speaks against the support: 'up_unknown', 'tilted' (by more than a ramp of 1 : 12), 'up_uncertain' (by more than "
          "3 degrees) or 'something_lower' (it stands for the floor, and something is seen below it); else None.")
      .def_prop_ro(
          "ground",
          [](const S& s) -> nb::object {
            const Found& found = s.found();
            if (!found.obstacles_asked) return nb::none();
            return nb::cast(found.obstacles.ground);
          },
          nb::sig("def ground(self) -> Ground | None"),
          "Coordinates on the support, or without one on a level plane below all that is seen; None without obstacles=True.")
      .def_prop_ro("residuals", &residuals_of, nb::sig("def residuals(self) -> numpy.typing.NDArray[numpy.float32] | None"),
                   "Distance of each pixel to its plane, metres, NaN where there is none; None without residuals=True.")
      .def_prop_ro(
          "method", [](const S& s) { return word(s.found().planes.method); }, nb::sig("def method(self) -> str"),
          "The method that ran; never 'auto'.")
      .def_prop_ro(
          "stop_reason", [](const S& s) { return nb::str(to_string(s.found().planes.stop_reason).data()); },
          nb::sig("def stop_reason(self) -> str"),
          "Why the first plane's search ended: 'confidence', 'max_iterations' or 'degenerate'.")
      .def_prop_ro(
          "timing_ms", [](const S& s) { return timing_of(s.found()); }, nb::sig("def timing_ms(self) -> dict[str, float]"),
          "Milliseconds by stage, and 'total'.")
      .def_prop_ro(
          "up",
          [](const S& s) -> nb::object {
            const auto& up = s.found().planes.up;
            return up ? to_numpy(*up) : nb::none();
          },
          nb::sig("def up(self) -> " FRANSAC_VECTOR " | None"),
          "Unit vector in the input's coordinates, shape (3,); None: unknown.")
      .def_prop_ro(
          "up_source", [](const S& s) { return word(s.found().planes.up_source); }, nb::sig("def up_source(self) -> str"),
          "'given', 'estimated' or 'none'.")
      .def_prop_ro(
          "up_sigma_rad",
          [](const S& s) -> nb::object {
            if (s.found().planes.up_source != UpSource::estimated) return nb::none();
            return nb::float_(s.found().planes.up_sigma_rad);
          },
          nb::sig("def up_sigma_rad(self) -> float | None"),
          "One sigma of the estimated up's angle, radians; None where up is given or unknown.")
      .def_prop_ro(
          "sensor_position",
          [](const S& s) -> nb::object {
            const auto& position = s.found().planes.sensor_position;
            return position ? to_numpy(*position) : nb::none();
          },
          nb::sig("def sensor_position(self) -> " FRANSAC_VECTOR " | None"),
          "Where the sensor was, in the input's coordinates, metres, shape (3,); None: unknown.")
      .def_prop_ro(
          "noise", [](const S& s) { return noise_of(s.found(), s.found().planes.noise); },
          nb::sig("def noise(self) -> dict[str, float] | None"),
          "Pixel noise that cells worked with, independent from pixel to pixel: one sigma of a depth z is the root of "
          "constant_m**2 + "
          "(linear * z)**2 + (quadratic_per_m * z**2)**2. None for other methods.")
      .def_prop_ro(
          "slow_noise", [](const S& s) { return noise_of(s.found(), s.found().planes.slow_noise); },
          nb::sig("def slow_noise(self) -> dict[str, float] | None"),
          "The same of what pixels near each other share, over tens of pixels. None for other methods.")
      .def_prop_ro(
          "bias_m",
          [](const S& s) -> nb::object {
            if (s.found().planes.method != Method::cells) return nb::none();
            return nb::float_(s.found().planes.bias_m);
          },
          nb::sig("def bias_m(self) -> float | None"),
          "By how much cells took planes to be bent or shifted, the same in every frame, metres. None for other methods.")
      .def_prop_ro(
          "iterations", [](const S& s) { return s.found().planes.iterations; }, "Hypotheses, over all planes.")
      .def_prop_ro(
          "valid_points", [](const S& s) { return s.found().planes.valid_points; }, "Measured pixels or points.")
      .def_prop_ro(
          "sampled_points", [](const S& s) { return s.found().planes.sampled_points; }, "Points that were searched.")
      .def_prop_ro(
          "camera", [](const S& s) { return s.found().camera ? nb::cast(*s.found().camera) : nb::none(); },
          nb::sig("def camera(self) -> Camera | None"), "Of a depth image; None for a cloud.")
      .def(
          "picture",
          [](const S& s, nb::handle depth, nb::handle colour) {
            io::ColourImage image = picture_of(s.found(), depth, colour);
            const Shape shape{static_cast<std::size_t>(image.height), static_cast<std::size_t>(image.width), 3};
            return array_from(std::move(image.pixels), shape);
          },
          nb::arg("depth") = nb::none(), nb::arg("colour") = nb::none(),
          nb::sig("def picture(self, depth: numpy.typing.NDArray[typing.Any] | None = None, colour: "
                  "numpy.typing.NDArray[numpy.uint8] | None = None) -> numpy.typing.NDArray[numpy.uint8]"),
          "The planes in colour, (H, W, 3) uint8, over the depth image or a colour picture of its size where given.\n\n"
          "Raises ValueError for a cloud, and for arrays of another size.")
      .def_prop_ro(
          "note",
          [](const S& s) -> nb::object {
            return s.found().note.empty() ? nb::object(nb::none()) : nb::object(nb::cast(s.found().note));
          },
          nb::sig("def note(self) -> str | None"),
          "Why there is no plane or no support, and what to try; None where there are planes and, with obstacles=True, a "
          "support.")
      .def("__getstate__", [](const S& s) { return saved(s.found()); })
      .def("__setstate__",
           [](S& self, const nb::bytes& state) {
             Found found = loaded<Found>(state);
             if (!hangs_together(found)) raise_value_error("state: sizes differ");
             new (&self) S;
             self.found() = std::move(found);
           })
      .def(
          "__repr__", [](nb::handle self) { return nb::module_::import_("fransac._display").attr("segmentation")(self); },
          nb::sig("def __repr__(self) -> str"))
      .def(
          "_repr_html_", [](nb::handle self) { return nb::module_::import_("fransac._display").attr("html")(self); },
          nb::sig("def _repr_html_(self) -> str"));
}

constexpr const char* kErrors = R"(
Raises
------
    TypeError: an unknown option, or a value of another type than its own; the message names it.
    ValueError: a value out of its range, a shape that does not fit; the message names the argument.
    NoDataError: fewer than three measured points, none within the pass-through limits, or all on one line.
    MemoryError: not enough memory.
)";

const char* keep(std::string text) { return (new std::string(std::move(text)))->c_str(); }

std::string keyword_section() {
  return "\nOptions (keywords)\n------------------\n" + descriptions(segment_keywords().list()) +
         "\nOptions with obstacles=True\n---------------------------\n" + descriptions(obstacle_keywords().list());
}

}  // namespace

PySegmentation::PySegmentation() : found_(Pool::instance().take()) {}
PySegmentation::~PySegmentation() {
  if (found_) Pool::instance().give(std::move(found_));
}

void bind_segmentation(nb::module_& m) {
  bind_evidence(m);
  bind_plane(m);
  bind_obstacle(m);
  bind_result(m);

  const std::string method = "method: " + literal(EnumNames<Method>::values, std::size(EnumNames<Method>::values)) + " = 'auto'";
  const std::string options = "obstacles: bool = False, " + parameters(segment_keywords().list()) + ", " +
                              parameters(obstacle_keywords().list()) + ") -> Segmentation";
  m.def("segment", &segment_depth, nb::arg("depth").none(), nb::arg("camera") = nb::none(), nb::arg("method") = "auto",
        nb::kw_only(), nb::arg("obstacles") = false, nb::arg("options"),
        nb::sig(keep("def segment(depth: numpy.typing.NDArray[typing.Any], camera: " FRANSAC_CAMERA " | None = None, " + method +
                     ", *, fx: float = ..., fy: float = ..., cx: float = ..., cy: float = ..., depth_scale: float = 1000.0, " +
                     options)),
        keep(R"(Finds the planes of a depth image, and on request its obstacles.

Parameters
----------
    depth: (H, W) array of z along the optical axis. uint16: raw units, metres = value / camera.depth_scale, 0 is no measurement.
        float32 and float64: metres; 0, negative, NaN and infinite values are no measurement. Read in place where the values of a
        row lie side by side; other strides, float64, float16, whole numbers of other types from 0 to 65535, and other byte orders
        are copied once. What a masked array hides is no measurement.
    camera: a Camera, a dict of its fields, the path of a camera's file, 'freiburg1' to 'freiburg3', or None with the keywords fx, fy,
        cx, cy and depth_scale. Must be of the image's size; a dict may leave the size out.
    method: how planes are found; 'auto' is 'cells', every plane of the image.
    obstacles: whether to look for obstacles, too.
)" + keyword_section() +
             kErrors));
  m.def("segment_cloud", &segment_cloud, nb::arg("points").none(), nb::arg("method") = "auto", nb::kw_only(),
        nb::arg("obstacles") = false, nb::arg("options"),
        nb::sig(keep("def segment_cloud(points: numpy.typing.NDArray[typing.Any], " + method + ", *, " + options)),
        keep(R"(Finds the planes of a point cloud, and on request its obstacles.

Parameters
----------
    points: (N, 3) or, organised, (H, W, 3) array of float32 or float64, metres, with any strides; other numbers are converted, and a
        fourth value of each point is not looked at. Points that are not finite, that a masked array hides, or that are
        exactly (0, 0, 0), are no measurements: label 0. Coordinates of any size keep their precision.
    method: how planes are found; 'auto' is 'cells' for what a pinhole camera saw, else 'fransac', which finds one plane unless planes
        says otherwise.
    obstacles: whether to look for obstacles, too.
)" + keyword_section() +
             kErrors));
  m.def(
      "png_of", [](const PySegmentation& s) { return png_of(picture_of(s.found(), nb::none(), nb::none())); },
      nb::arg("segmentation"), nb::sig("def png_of(segmentation: Segmentation) -> bytes"), "Its picture as a PNG file.");
  m.def("time_in_cpp", &time_in_cpp, nb::arg("depth").none(), nb::arg("camera"), nb::arg("repeat"),
        nb::sig("def time_in_cpp(depth: numpy.typing.NDArray[typing.Any], camera: Camera, repeat: int) -> list[float]"),
        "Milliseconds of calls of the library itself, for benchmarks.");
}

}  // namespace fransac::python

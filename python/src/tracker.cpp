// SPDX-License-Identifier: Apache-2.0
#include "fransac/track/tracker.hpp"

#include <nanobind/nanobind.h>

#include <cstring>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "arrays.hpp"
#include "bindings.hpp"
#include "options.hpp"
#include "segmentation.hpp"

namespace fransac::python {
namespace {

const Keywords<TrackOptions>& track_keywords() {
  static const auto& keywords = *new Keywords<TrackOptions>();
  return keywords;
}

TrackOptions read_options(const nb::kwargs& kwargs) {
  TrackOptions options;
  if (track_keywords().read(kwargs, options) != kwargs.size()) reject_unknown("Tracker", kwargs, {&track_keywords().list()});
  check(validate(options));
  return options;
}

/// A rigid motion as a 4 x 4 matrix; none: unknown.
std::optional<Eigen::Isometry3d> read_pose(nb::handle given) {
  if (given.is_none()) return std::nullopt;
  const Array array = import_array("pose", given, "an array of shape (4, 4)");
  nb::ndarray<const double, nb::shape<4, 4>, nb::device::cpu> matrix;
  if (!nb::try_cast(given, matrix, false)) {
    raise_value_error("pose: expected a float64 array of shape (4, 4), got shape " + shape_text(array));
  }
  const auto view = matrix.view();
  Eigen::Matrix4d pose;
  for (Eigen::Index row = 0; row < 4; ++row) {
    for (Eigen::Index column = 0; column < 4; ++column) pose(row, column) = view(row, column);
  }
  constexpr double kRigid = 1e-6;  // poses from files have six or more digits
  const Eigen::Matrix3d rotation = pose.topLeftCorner<3, 3>();
  const bool rigid = pose.allFinite() && (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() < kRigid &&
                     rotation.determinant() > 0.0 && pose.row(3) == Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0);
  if (!rigid) raise_value_error("pose: not a rotation and a translation over the row 0, 0, 0, 1");
  Eigen::Isometry3d isometry;
  isometry.matrix() = pose;
  return isometry;
}

/// A tracker that several threads may call; they take turns.
class PyTracker {
 public:
  explicit PyTracker(const TrackOptions& options) : tracker_(options) {}

  TrackedFrame update(const PySegmentation& segmentation, nb::handle given_pose) {
    const std::optional<Eigen::Isometry3d> pose = read_pose(given_pose);
    const Found& found = segmentation.found();
    TrackedFrame frame;
    Status status;
    {
      const nb::gil_scoped_release release;
      const std::lock_guard lock(mutex_);
      status = tracker_.update(found.planes, found.obstacles_asked ? &found.obstacles : nullptr, pose, frame);
    }
    check(status);
    return frame;
  }

  void reset() {
    const nb::gil_scoped_release release;
    const std::lock_guard lock(mutex_);
    tracker_.reset();
  }

 private:
  std::mutex mutex_;
  Tracker tracker_;
};

template <class Item>
nb::list list_of(const std::vector<Item>& items) {
  nb::list list;
  for (const Item& item : items) list.append(nb::cast(item, nb::rv_policy::copy));
  return list;
}

const char* keep(std::string text) { return (new std::string(std::move(text)))->c_str(); }

}  // namespace

void bind_tracker(nb::module_& m) {
  nb::class_<TrackedPlane>(m, "TrackedPlane", "A plane that keeps its id from frame to frame, smoothed.")
      .def_ro("id", &TrackedPlane::id, "For as long as it is tracked, from 1; no two have the same.")
      .def_ro("label", &TrackedPlane::label, "Of the frame's segmentation.")
      .def_prop_ro(
          "normal", [](const TrackedPlane& p) { return to_numpy(p.plane.normal); },
          nb::sig("def normal(self) -> " FRANSAC_VECTOR), "Unit normal in this frame's camera frame, shape (3,).")
      .def_prop_ro(
          "d", [](const TrackedPlane& p) { return p.plane.d; }, "Distance of the camera, metres.")
      .def_prop_ro(
          "covariance", [](const TrackedPlane& p) { return to_numpy(Eigen::Matrix4d(p.covariance)); },
          nb::sig("def covariance(self) -> " FRANSAC_VECTOR), "Of (normal, d), shape (4, 4), rank 3.")
      .def_ro("age", &TrackedPlane::age, "Frames in which it was seen, this one included.")
      .def(
          "__repr__",
          [](const TrackedPlane& p) {
            return nb::str("<TrackedPlane {}, label {}, age {}>").attr("format")(p.id, p.label, p.age);
          },
          nb::sig("def __repr__(self) -> str"));
  nb::class_<TrackedObject>(m, "TrackedObject", "An obstacle that keeps its id from frame to frame.")
      .def_ro("id", &TrackedObject::id, "As a plane's, counted by itself.")
      .def_ro("obstacle", &TrackedObject::obstacle, "Its id in the frame's obstacles.")
      .def_ro("age", &TrackedObject::age, "Frames in which it was seen, this one included.")
      .def(
          "__repr__",
          [](const TrackedObject& o) {
            return nb::str("<TrackedObject {}, obstacle {}, age {}>").attr("format")(o.id, o.obstacle, o.age);
          },
          nb::sig("def __repr__(self) -> str"));
  nb::class_<TrackedFrame>(m, "TrackedFrame", "What a tracker says of one frame.")
      .def_prop_ro(
          "pose", [](const TrackedFrame& f) { return to_numpy(f.T_world_camera.matrix()); },
          nb::sig("def pose(self) -> " FRANSAC_VECTOR),
          "T_world_camera, shape (4, 4): from the camera's frame to the first frame's, or to that of the poses given; metres.")
      .def_prop_ro(
          "pose_source", [](const TrackedFrame& f) { return nb::str(enum_name(f.pose_source).data()); },
          nb::sig("def pose_source(self) -> str"), "'given', 'estimated' or 'guessed'.")
      .def_prop_ro(
          "planes", [](const TrackedFrame& f) { return list_of(f.planes); }, nb::sig("def planes(self) -> list[TrackedPlane]"),
          "In the order of the segmentation.")
      .def_prop_ro(
          "objects", [](const TrackedFrame& f) { return list_of(f.objects); },
          nb::sig("def objects(self) -> list[TrackedObject]"), "In the order of the obstacles; drops are left out.");
  nb::class_<PyTracker>(
      m, "Tracker",
      keep(
          R"(Planes and obstacles that keep their ids from frame to frame, and the camera's pose. Feed it frames in order; threads take
turns. docs/algorithms.md, "Tracking", derives the steps.

Options (keywords)
------------------
)" + descriptions(track_keywords().list())))
      .def(
          "__init__", [](PyTracker* self, const nb::kwargs& kwargs) { new (self) PyTracker(read_options(kwargs)); },
          nb::arg("options"), nb::sig(keep("def __init__(self, *, " + parameters(track_keywords().list()) + ") -> None")))
      .def("update", &PyTracker::update, nb::arg("segmentation"), nb::arg("pose") = nb::none(),
           nb::sig("def update(self, segmentation: Segmentation, pose: " FRANSAC_VECTOR " | None = None) -> TrackedFrame"),
           R"(Takes the next frame.

Parameters
----------
    segmentation: of method 'cells'; its obstacles are tracked where they were asked for.
    pose: T_world_camera, (4, 4) float64, where it is known; known in one frame, it should be in all.

Raises
------
    ValueError: a pose that is no rotation and translation; a method without covariances.)")
      .def("reset", &PyTracker::reset, "Forgets everything but the options.");
}

}  // namespace fransac::python

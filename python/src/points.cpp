// SPDX-License-Identifier: Apache-2.0
// Steps of the way on their own: the voxel grid, and RANSAC of one plane.
#include <nanobind/nanobind.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "fransac/filter/voxel_grid.hpp"
#include "fransac/sac/plane_problem.hpp"
#include "fransac/sac/ransac.hpp"
#include "options.hpp"

namespace fransac::python {
namespace {

/// What a thread keeps from call to call.
struct Work {
  PointCloud cloud;
  PointCloud sample;
  VoxelGrid grid;
  sac::RansacWorkspace<sac::PlaneProblem> ransac;
};
Work& work_of_thread() {
  thread_local Work work;
  return work;
}

const Keywords<SegmentOptions>& grid_keywords() {
  static const auto& keywords = *new Keywords<SegmentOptions>({"leaf_point", "threads"});
  return keywords;
}
const Keywords<SegmentOptions>& ransac_keywords() {
  static const auto& keywords = *new Keywords<SegmentOptions>({"threshold", "probability", "max_iterations", "pretest_points",
                                                               "scoring", "local_optimisation", "refine", "seed", "threads"});
  return keywords;
}

/// The options that `kwargs` name, checked.
SegmentOptions read_options(const char* function, const Keywords<SegmentOptions>& keywords, const nb::kwargs& kwargs,
                            SegmentOptions options = {}) {
  if (keywords.read(kwargs, options) != kwargs.size()) reject_unknown(function, kwargs, {&keywords.list()}, {"leaf_size"});
  check(validate(options));
  return options;
}

struct PyVoxelGrid {
  nb::object points;
  nb::object counts;
  nb::object leaf_of;
};

template <class T>
std::vector<T> coordinates_of(const PointCloud& cloud) {
  std::vector<T> values(3 * cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d point = cloud.point(i);
    for (std::size_t axis = 0; axis < 3; ++axis) values[3 * i + axis] = static_cast<T>(point[static_cast<Eigen::Index>(axis)]);
  }
  return values;
}

PyVoxelGrid voxel_grid_of(nb::handle given, nb::handle leaf_size, const nb::kwargs& kwargs) {
  const PointsInput points("points", given);
  SegmentOptions options;
  read_value("leaf_size", leaf_size, options.voxel_grid.leaf_size_m);
  options = read_options("voxel_grid", grid_keywords(), kwargs, options);
  Shape shape = points.shape();
  std::size_t size = 1;
  for (const std::size_t side : shape) size *= side;

  Status status;
  std::vector<std::int32_t> leaf_of(size, -1);
  std::vector<std::int32_t> counts;
  std::vector<float> floats;
  std::vector<double> doubles;
  {
    const nb::gil_scoped_release release;
    Work& work = work_of_thread();
    points.load_finite(work.cloud);
    const VoxelGridOptions& chosen = options.voxel_grid;
    if (!work.cloud.empty()) status = voxel_grid(work.cloud, chosen.leaf_size_m, chosen.leaf_point, work.grid, options.threads);
    if (status && !work.cloud.empty()) {
      for (std::size_t i = 0; i < work.cloud.size(); ++i) {
        leaf_of[work.cloud.source_of(i)] = static_cast<std::int32_t>(work.grid.leaf_of[i]);
      }
      counts.assign(work.grid.point_count.begin(), work.grid.point_count.end());
      if (points.is_double()) {
        doubles = coordinates_of<double>(work.grid.leaves);
      } else {
        floats = coordinates_of<float>(work.grid.leaves);
      }
    }
  }
  check(status);
  const std::size_t leaves = counts.size();
  return {points.is_double() ? array_from(std::move(doubles), {leaves, 3}) : array_from(std::move(floats), {leaves, 3}),
          array_from(std::move(counts), {leaves}), array_from(std::move(leaf_of), shape)};
}

struct PyRansac {
  std::optional<Plane> plane;
  nb::object inliers;
  double rms_m = 0.0;
  std::uint64_t iterations = 0;
  std::string stop_reason;
};

/// The points within the threshold, by their numbers in the input, and the root mean square of their distances.
std::vector<std::int64_t> inliers_of(const PointCloud& cloud, const Plane& plane, double threshold_m, double& rms_m) {
  std::vector<std::int64_t> inliers;
  double sum = 0.0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double distance = plane.signed_distance(cloud.local(i));
    if (std::abs(distance) > threshold_m) continue;
    inliers.push_back(cloud.source_of(i));
    sum += distance * distance;
  }
  rms_m = inliers.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(inliers.size()));
  return inliers;
}

PyRansac ransac_of(nb::handle given, const nb::kwargs& kwargs) {
  const PointsInput points("points", given);
  const SegmentOptions options = read_options("ransac", ransac_keywords(), kwargs);
  PyRansac result;
  std::vector<std::int64_t> inliers;
  bool enough = false;
  {
    const nb::gil_scoped_release release;
    Work& work = work_of_thread();
    points.load_finite(work.cloud);
    enough = work.cloud.size() >= 3;
    if (enough) {
      const RansacPlaneOptions& chosen = options.ransac;
      const sac::RansacOptions search{.probability = chosen.probability,
                                      .max_iterations = static_cast<std::uint32_t>(chosen.max_iterations),
                                      .pretest_points = chosen.pretest_points.value_or(0),
                                      .local_optimisation = chosen.local_optimisation,
                                      .seed = options.seed,
                                      .threads = options.threads};
      const sac::CloudData data(work.cloud, options.threads);
      const sac::PlaneProblem problem(data, chosen.threshold_m, chosen.scoring, options.seed, 0, work.sample);
      const auto found = sac::ransac(problem, search, work.ransac);
      result.iterations = found.iterations;
      result.stop_reason = to_string(found.stop_reason);
      if (found.model) {
        Plane plane = *found.model;
        if (chosen.refine) plane = problem.refine_on_all(plane).value_or(plane);
        inliers = inliers_of(work.cloud, plane, chosen.threshold_m, result.rms_m);
        result.plane = translated(plane, -work.cloud.origin);
      }
    }
  }
  if (!enough) throw NoData("points: fewer than three are finite");
  if (!result.plane) throw NoData("points: all are on one line or coincide; they determine no plane");
  const std::size_t size = inliers.size();
  result.inliers = array_from(std::move(inliers), {size});
  return result;
}

const char* keep(std::string text) { return (new std::string(std::move(text)))->c_str(); }

}  // namespace

void bind_points(nb::module_& m) {
  nb::class_<PyVoxelGrid>(m, "VoxelGrid", "One point per occupied cube of a regular grid.")
      .def_prop_ro(
          "points", [](const PyVoxelGrid& g) { return g.points; },
          nb::sig("def points(self) -> numpy.typing.NDArray[typing.Any]"),
          "Of the leaves, (M, 3), metres, of the input's type, in the order in which the input first enters them.")
      .def_prop_ro(
          "counts", [](const PyVoxelGrid& g) { return g.counts; },
          nb::sig("def counts(self) -> numpy.typing.NDArray[numpy.int32]"), "Input points in each leaf, (M,) int32.")
      .def_prop_ro(
          "leaf_of", [](const PyVoxelGrid& g) { return g.leaf_of; },
          nb::sig("def leaf_of(self) -> numpy.typing.NDArray[numpy.int32]"),
          "The leaf of each input point, int32 of shape (N,) or (H, W); -1 for points that are not finite.")
      .def("__len__", [](const PyVoxelGrid& g) { return nb::len(g.counts); })
      .def("__repr__", [](const PyVoxelGrid& g) {
        return nb::str(("VoxelGrid of " + std::to_string(nb::len(g.counts)) + " leaves").c_str());
      });
  m.def("voxel_grid", &voxel_grid_of, nb::arg("points").none(), nb::arg("leaf_size") = VoxelGridOptions{}.leaf_size_m,
        nb::arg("options"),
        nb::sig(keep("def voxel_grid(points: numpy.typing.NDArray[typing.Any], leaf_size: float = " +
                     std::string(nb::repr(nb::float_(VoxelGridOptions{}.leaf_size_m)).c_str()) + ", *, " +
                     parameters(grid_keywords().list()) + ") -> VoxelGrid")),
        keep(R"(Sorts points into cubes and keeps one point for each.

Parameters
----------
    points: (N, 3) or (H, W, 3) array of float32 or float64, metres, with any strides. Points that are not finite are in no leaf.
    leaf_size: edge of a cube, metres. The lattice contains the origin.

Options (keywords)
------------------
)" + descriptions(grid_keywords().list()) +
             R"(
Raises
------
    TypeError, ValueError: as segment; the message names the argument. A leaf too small for the cloud's extent is a ValueError.
)"));

  nb::class_<PyRansac>(m, "RansacResult", "A plane, n . p + d = 0 in metres, and the points within the threshold.")
      .def_prop_ro(
          "normal", [](const PyRansac& r) { return to_numpy(r.plane->normal); }, nb::sig("def normal(self) -> " FRANSAC_VECTOR),
          "Unit normal, shape (3,); the origin is on its side.")
      .def_prop_ro(
          "d", [](const PyRansac& r) { return r.plane->d; }, "Distance of the origin, metres, >= 0.")
      .def_prop_ro(
          "coefficients",
          [](const PyRansac& r) {
            const Eigen::Vector4d all(r.plane->normal.x(), r.plane->normal.y(), r.plane->normal.z(), r.plane->d);
            return copied_array(all.data(), {4});
          },
          nb::sig("def coefficients(self) -> " FRANSAC_VECTOR), "(normal, d), shape (4,).")
      .def_prop_ro(
          "inliers", [](const PyRansac& r) { return r.inliers; },
          nb::sig("def inliers(self) -> numpy.typing.NDArray[numpy.int64]"),
          "Numbers of the points within the threshold, ascending.")
      .def_ro("rms_m", &PyRansac::rms_m, "Root mean square distance of the inliers, metres.")
      .def_ro("iterations", &PyRansac::iterations, "Hypotheses drawn.")
      .def_prop_ro(
          "stop_reason", [](const PyRansac& r) { return nb::str(r.stop_reason.c_str()); },
          nb::sig("def stop_reason(self) -> str"), "'confidence' or 'max_iterations'.")
      .def(
          "__repr__", [](nb::handle self) { return nb::module_::import_("fransac._display").attr("ransac")(self); },
          nb::sig("def __repr__(self) -> str"));
  m.def(
      "ransac", &ransac_of, nb::arg("points").none(), nb::arg("options"),
      nb::sig(keep("def ransac(points: numpy.typing.NDArray[typing.Any], *, " + parameters(ransac_keywords().list()) +
                   ") -> RansacResult")),
      keep(
          R"(The plane with the most support, by RANSAC (Fischler & Bolles 1981) with eq. 2 of Zeineldin & El-Fishawy as its stop.

Parameters
----------
    points: (N, 3) or (H, W, 3) array of float32 or float64, metres, with any strides. Points that are not finite are no inliers.

Options (keywords)
------------------
)" + descriptions(ransac_keywords().list()) +
          R"(
Raises
------
    TypeError, ValueError: as segment; the message names the argument.
    NoDataError: fewer than three finite points, or all on one line.
)"));
}

}  // namespace fransac::python

// SPDX-License-Identifier: Apache-2.0
#include "camera.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <string>
#include <tuple>

#include "bindings.hpp"
#include "fransac/io/camera_file.hpp"
#include "options.hpp"

namespace fransac::python {
namespace {

/// Calls visit(name, value&) for every field.
template <class Visitor>
void for_each_field(Camera& camera, Visitor&& visit) {
  visit("width", camera.width);
  visit("height", camera.height);
  visit("fx", camera.fx);
  visit("fy", camera.fy);
  visit("cx", camera.cx);
  visit("cy", camera.cy);
  visit("depth_scale", camera.depth_scale);
}

bool may_be_left_out(const std::string& field) { return field == "width" || field == "height" || field == "depth_scale"; }

/// Fields out of a mapping, other keys aside; counts them.
std::size_t read_fields(nb::handle mapping, const std::string& missing_in, bool with_size, Camera& camera) {
  std::size_t used = 0;
  for_each_field(camera, [&](const char* name, auto& value) {
    const bool size = std::string_view(name) == "width" || std::string_view(name) == "height";
    if (size && !with_size) return;
    const nb::str key(name);
    if (PyMapping_HasKey(mapping.ptr(), key.ptr()) == 0) {
      if (!may_be_left_out(name)) raise_type_error(missing_in + " '" + name + "' is missing");
      return;
    }
    read_value(name, nb::object(mapping[key]), value);
    ++used;
  });
  return used;
}

Camera camera_from_mapping(nb::handle mapping, int width, int height) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  const std::size_t used = read_fields(mapping, "camera:", true, camera);
  if (used != static_cast<std::size_t>(PyMapping_Size(mapping.ptr()))) {
    std::vector<Keyword> fields;
    for_each_field(camera, [&](const char* name, auto&) { fields.push_back({name, {}, {}, {}}); });
    const nb::object dict = nb::module_::import_("builtins").attr("dict")(mapping);
    reject_unknown("camera", nb::cast<nb::dict>(dict), {&fields});
  }
  return camera;
}

Camera camera_from_file(nb::handle path) {
  const nb::object name = nb::module_::import_("os").attr("fspath")(path);
  if (!nb::isinstance<nb::str>(name)) raise_type_error("camera: expected a path as a str");
  const std::string text = nb::cast<nb::str>(name).c_str();
  if (const auto known = io::tum_camera(text)) return *known;
  return unwrap(io::pinhole_of(unwrap(io::read_camera_file(text)), text));
}

std::string repr(const Camera& camera) {
  Camera copy = camera;
  std::string text;
  for_each_field(copy, [&](const char* name, const auto& value) {
    const nb::object number = nb::cast(value);
    text += (text.empty() ? "" : ", ") + std::string(name) + "=" + nb::repr(number).c_str();
  });
  return "Camera(" + text + ")";
}

nb::dict to_dict(const Camera& camera) {
  Camera copy = camera;
  nb::dict dict;
  for_each_field(copy, [&](const char* name, const auto& value) { dict[name] = value; });
  return dict;
}

}  // namespace

Camera read_camera(nb::handle given, int width, int height) {
  Camera camera;
  if (nb::isinstance<Camera>(given)) {
    camera = nb::cast<Camera>(given);
  } else if (nb::isinstance<nb::str>(given) || nb::hasattr(given, "__fspath__")) {
    camera = camera_from_file(given);
  } else if (nb::isinstance<nb::dict>(given) || nb::hasattr(given, "keys")) {
    camera = camera_from_mapping(given, width, height);
  } else {
    raise_type_error(std::string("camera: expected a Camera, a dict or the path of a camera's file, got ") +
                     nb::type_name(given.type()).c_str());
  }
  check(validate(camera));
  return camera;
}

Camera read_camera_keywords(const char* function, const nb::dict& kwargs, int width, int height, std::size_t& used) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  used = read_fields(kwargs, std::string(function) + "() needs a camera, or fx, fy, cx and cy:", false, camera);
  check(validate(camera));
  return camera;
}

void bind_camera(nb::module_& m) {
  nb::class_<Camera>(
      m, "Camera",
      R"(Pinhole intrinsics of a depth image. A pixel (u, v) of depth z lies at z * ((u - cx) / fx, (v - cy) / fy, 1): x right,
y down, z forward; pixel (0, 0) is the centre of the top left one. Cannot be changed; equal cameras have equal hashes.

Parameters
----------
    width, height: pixels, 1 to 32768.
    fx, fy: focal lengths, pixels.
    cx, cy: principal point, pixels.
    depth_scale: raw units of integer depth per metre: metres = value / depth_scale.

Raises
------
    ValueError: a number is not finite or out of its range; the message names the field.)")
      .def(
          "__init__",
          [](Camera* self, int width, int height, double fx, double fy, double cx, double cy, double depth_scale) {
            const Camera camera{width, height, fx, fy, cx, cy, depth_scale};
            check(validate(camera));
            new (self) Camera(camera);
          },
          nb::kw_only(), nb::arg("width"), nb::arg("height"), nb::arg("fx"), nb::arg("fy"), nb::arg("cx"), nb::arg("cy"),
          nb::arg("depth_scale") = Camera{}.depth_scale)
      .def_static(
          "from_file", [](nb::handle path) { return camera_from_file(path); }, nb::arg("path").none(),
          nb::sig("def from_file(path: str | os.PathLike[str]) -> Camera"),
          "Reads a camera's file (camera.json, ROS, Open3D, RealSense, ORB-SLAM), or returns the camera of the TUM RGB-D "
          "benchmark's 'freiburg1', 'freiburg2' or 'freiburg3'.\n\n"
          "Raises OSError for a file that cannot be read, ValueError for one whose content is wrong.")
      .def_ro("width", &Camera::width, "Columns, pixels.")
      .def_ro("height", &Camera::height, "Rows, pixels.")
      .def_ro("fx", &Camera::fx, "Focal length along u, pixels.")
      .def_ro("fy", &Camera::fy, "Focal length along v, pixels.")
      .def_ro("cx", &Camera::cx, "Principal point, column, pixels.")
      .def_ro("cy", &Camera::cy, "Principal point, row, pixels.")
      .def_ro("depth_scale", &Camera::depth_scale, "Raw units of integer depth per metre.")
      .def("to_dict", &to_dict, nb::sig("def to_dict(self) -> dict[str, float]"), "The fields by name, as camera.json has them.")
      .def("__repr__", &repr)
      .def(
          "__eq__", [](const Camera& a, nb::handle b) { return nb::isinstance<Camera>(b) && a == nb::cast<Camera>(b); },
          nb::sig("def __eq__(self, other: object, /) -> bool"))
      .def(
          "__getstate__",
          [](const Camera& c) { return nb::make_tuple(c.width, c.height, c.fx, c.fy, c.cx, c.cy, c.depth_scale); },
          nb::sig("def __getstate__(self) -> tuple[int, int, float, float, float, float, float]"))
      .def("__setstate__",
           [](Camera& self, const std::tuple<int, int, double, double, double, double, double>& state) {
             const Camera camera = std::make_from_tuple<Camera>(state);
             check(validate(camera));
             new (&self) Camera(camera);
           })
      .def("__hash__", [](const Camera& camera) {
        return PyObject_Hash(
            nb::make_tuple(camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy, camera.depth_scale).ptr());
      });
}

}  // namespace fransac::python

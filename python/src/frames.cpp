// SPDX-License-Identifier: Apache-2.0
// Where frames come from: files, and rendered scenes.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "arrays.hpp"
#include "bindings.hpp"
#include "camera.hpp"
#include "fransac/io/dataset.hpp"
#include "fransac/synth/synth.hpp"
#include "options.hpp"

namespace fransac::python {
namespace {

/// A frame's arrays and what is known of it.
struct PyFrame {
  std::string name;
  std::optional<double> timestamp_s;
  Camera camera;
  nb::object depth;
  nb::object labels;
  nb::object objects;
};

struct PySynthFrame {
  Camera camera;
  nb::object depth;
  nb::object exact_depth;
  nb::object labels;
  nb::object objects;
  nb::object colour;
  nb::list planes;
  Eigen::Matrix4d pose;
};

Shape shape_of(const Camera& camera) { return {static_cast<std::size_t>(camera.height), static_cast<std::size_t>(camera.width)}; }

std::string path_of(const char* argument, nb::handle given) {
  const nb::object path = nb::module_::import_("os").attr("fspath")(given);
  if (!nb::isinstance<nb::str>(path)) raise_type_error(std::string(argument) + ": expected a path as a str");
  return nb::cast<std::string>(path);
}

nb::list list_frames(nb::handle given, std::optional<std::size_t> max_size) {
  if (max_size == 0) throw nb::value_error("max_size: must be at least 1");
  const std::string path = path_of("path", given);
  io::Dataset dataset = unwrap(without_gil([&] { return io::list_frames(path); }));
  nb::list frames;
  for (io::FrameFiles& files : dataset.frames) {
    if (max_size) files.limits.max_size = *max_size;
    frames.append(nb::cast(std::move(files)));
  }
  return frames;
}

PyFrame load_frame(const io::FrameFiles& files, nb::handle given_camera) {
  io::FrameFiles wanted = files;
  const bool overridden = !given_camera.is_none();
  if (overridden) {
    wanted.camera_file.reset();
    const io::RawDepth image = unwrap(io::read_depth_image(files.depth, files.limits));
    const bool metres = !image.metres.pixels.empty();
    wanted.camera = read_camera(given_camera, metres ? image.metres.width : image.units.width,
                                metres ? image.metres.height : image.units.height);
  }
  io::Frame frame = unwrap(without_gil([&] { return io::load_frame(wanted); }));
  const Shape shape = shape_of(frame.camera);
  PyFrame result;
  result.name = frame.name;
  result.timestamp_s = files.timestamp_s;
  result.camera = frame.camera;
  result.depth = frame.metres.pixels.empty() ? array_from(std::move(frame.depth.pixels), shape)
                                             : array_from(std::move(frame.metres.pixels), shape);
  result.labels = frame.labels ? array_from(std::move(frame.labels->pixels), shape) : nb::none();
  result.objects = frame.objects ? array_from(std::move(frame.objects->pixels), shape) : nb::none();
  return result;
}

PySynthFrame synthesise(nb::handle scene, nb::handle noise, nb::handle seed, nb::handle frame, nb::handle motion,
                        nb::handle camera) {
  synth::SynthOptions options;
  if (!nb::isinstance<nb::str>(scene)) raise_type_error("scene: expected a str");
  options.scene = nb::cast<std::string>(scene);
  read_value("noise", noise, options.sensor);
  read_value("seed", seed, options.seed);
  read_value("frame", frame, options.frame);
  read_value("motion", motion, options.motion);
  if (!camera.is_none()) options.camera = read_camera(camera, options.camera.width, options.camera.height);
  synth::SynthFrame rendered = unwrap(without_gil([&] { return synth::render(options); }));
  const Shape shape = shape_of(rendered.camera);
  PySynthFrame result;
  result.camera = rendered.camera;
  result.depth = array_from(std::move(rendered.depth), shape);
  result.exact_depth = array_from(std::move(rendered.exact_depth_m), shape);
  result.labels = array_from(std::move(rendered.labels), shape);
  result.objects = array_from(std::move(rendered.objects), shape);
  result.colour = array_from(std::move(rendered.colour), {shape[0], shape[1], 3});
  for (const auto& [label, plane] : rendered.true_planes) {
    result.planes.append(nb::make_tuple(label, to_numpy(plane.normal), plane.d));
  }
  result.pose = rendered.T_world_camera.matrix();
  return result;
}

#define FRANSAC_ARRAY(type) "numpy.typing.NDArray[numpy." type "]"

void bind_files(nb::module_& m) {
  nb::class_<io::FrameFiles>(m, "FrameFiles", "Where a frame's files are; nothing is loaded yet.");
  m.def("list_frames", &list_frames, nb::arg("path").none(), nb::arg("max_size") = nb::none(),
        nb::sig("def list_frames(path: str | os.PathLike[str], max_size: int | None = None) -> list[FrameFiles]"));
  m.def("load_frame", &load_frame, nb::arg("files"), nb::arg("camera") = nb::none(),
        nb::sig("def load_frame(files: FrameFiles, camera: " FRANSAC_CAMERA " | None = None) -> Frame"));
  nb::class_<PyFrame>(m, "Frame", "A depth frame from files.")
      .def_ro("name", &PyFrame::name, "The frame folder's name, or the timestamp of a sequence.")
      .def_prop_ro(
          "timestamp_s", [](const PyFrame& f) { return f.timestamp_s ? nb::cast(*f.timestamp_s) : nb::none(); },
          nb::sig("def timestamp_s(self) -> float | None"), "Of a TUM sequence, seconds.")
      .def_ro("camera", &PyFrame::camera, "Of the image's size.")
      .def_prop_ro(
          "depth", [](const PyFrame& f) { return f.depth; },
          nb::sig("def depth(self) -> " FRANSAC_ARRAY("uint16") " | " FRANSAC_ARRAY("float32")),
          "(H, W) uint16, raw units: metres = value / camera.depth_scale; or float32, metres, where the file holds floats. 0 is "
          "no measurement.")
      .def_prop_ro(
          "labels", [](const PyFrame& f) { return f.labels; }, nb::sig("def labels(self) -> " FRANSAC_ARRAY("uint8") " | None"),
          "True labels, (H, W) uint8, where the frame has some.")
      .def_prop_ro(
          "objects", [](const PyFrame& f) { return f.objects; },
          nb::sig("def objects(self) -> " FRANSAC_ARRAY("uint16") " | None"),
          "True objects, (H, W) uint16, where the frame has some.")
      .def(
          "__repr__",
          [](const PyFrame& f) {
            return nb::str("<Frame '{}', {} x {}>").attr("format")(f.name, f.camera.width, f.camera.height);
          },
          nb::sig("def __repr__(self) -> str"));
}

std::string scene_doc() {
  std::string scenes;
  for (const std::string_view name : synth::scene_names()) scenes += (scenes.empty() ? "'" : ", '") + std::string(name) + "'";
  return R"(Renders a frame of a made-up scene with exact truth. The same arguments give the same bytes.

Parameters
----------
    scene: )" +
         scenes + R"(.
    noise: how depth is measured: 'none' is exact; 'kinect1' structured light; 'stereo'; 'tof' time of flight.
    seed: another seed, another room.
    frame: frames of one seed show one scene from a moving camera.
    motion: 'sway' about 1 cm, or 'walk' through the scene.
    camera: as segment takes it; without one 640 x 480 pixels of 0.2 mm.

Raises
------
    ValueError: an unknown scene, noise or motion, a camera out of its range, a negative frame.
)";
}

}  // namespace

void bind_frames(nb::module_& m) {
  bind_files(m);
  nb::class_<PySynthFrame>(m, "SynthFrame", "A rendered depth frame and the truth about it.")
      .def_ro("camera", &PySynthFrame::camera, "That took it.")
      .def_prop_ro(
          "depth", [](const PySynthFrame& f) { return f.depth; }, nb::sig("def depth(self) -> " FRANSAC_ARRAY("uint16")),
          "(H, W) uint16, raw units: metres = value / camera.depth_scale; 0 is no measurement.")
      .def_prop_ro(
          "exact_depth", [](const PySynthFrame& f) { return f.exact_depth; },
          nb::sig("def exact_depth(self) -> " FRANSAC_ARRAY("float32")),
          "(H, W) float32, metres, without noise; 0: the ray hits nothing.")
      .def_prop_ro(
          "labels", [](const PySynthFrame& f) { return f.labels; }, nb::sig("def labels(self) -> " FRANSAC_ARRAY("uint8")),
          "(H, W) uint8: 0 no depth or not to be judged, 1 the dominant plane, 2, ... others, 255 on no plane.")
      .def_prop_ro(
          "objects", [](const PySynthFrame& f) { return f.objects; }, nb::sig("def objects(self) -> " FRANSAC_ARRAY("uint16")),
          "(H, W) uint16: which free-standing thing each pixel sees; 0: none.")
      .def_prop_ro(
          "colour", [](const PySynthFrame& f) { return f.colour; }, nb::sig("def colour(self) -> " FRANSAC_ARRAY("uint8")),
          "(H, W, 3) uint8, a shaded picture.")
      .def_prop_ro(
          "planes", [](const PySynthFrame& f) { return f.planes; },
          nb::sig("def planes(self) -> list[tuple[int, " FRANSAC_VECTOR ", float]]"),
          "(label, normal, d) of the true planes, in the camera's frame, metres.")
      .def_prop_ro(
          "pose", [](const PySynthFrame& f) { return to_numpy(f.pose); }, nb::sig("def pose(self) -> " FRANSAC_VECTOR),
          "T_world_camera, shape (4, 4), metres; the world's z is up.")
      .def(
          "__repr__",
          [](const PySynthFrame& f) {
            return nb::str("<SynthFrame, {} x {}, {} planes>").attr("format")(f.camera.width, f.camera.height, nb::len(f.planes));
          },
          nb::sig("def __repr__(self) -> str"));
  const synth::SynthOptions defaults;
  const auto quoted = [](std::string_view word) { return "'" + std::string(word) + "'"; };
  const std::string signature = "def synth(scene: str = " + quoted(defaults.scene) + ", *, noise: " +
                                literal(EnumNames<synth::Sensor>::values, std::size(EnumNames<synth::Sensor>::values)) + " = " +
                                quoted(enum_name(defaults.sensor)) + ", seed: int = 0, frame: int = 0, motion: " +
                                literal(EnumNames<synth::Motion>::values, std::size(EnumNames<synth::Motion>::values)) + " = " +
                                quoted(enum_name(defaults.motion)) + ", camera: " FRANSAC_CAMERA " | None = None) -> SynthFrame";
  static const std::string& kept_signature = *new std::string(signature);
  static const std::string& doc = *new std::string(scene_doc());
  m.def("synth", &synthesise, nb::arg("scene") = defaults.scene, nb::kw_only(),
        nb::arg("noise") = std::string(enum_name(defaults.sensor)), nb::arg("seed") = 0, nb::arg("frame") = 0,
        nb::arg("motion") = std::string(enum_name(defaults.motion)), nb::arg("camera") = nb::none(),
        nb::sig(kept_signature.c_str()), doc.c_str());
  nb::list names;
  for (const std::string_view name : synth::scene_names()) names.append(nb::str(name.data(), name.size()));
  m.attr("scene_names") = nb::tuple(names);
}

}  // namespace fransac::python

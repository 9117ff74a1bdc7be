// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <limits>
#include <string>
#include <vector>

#include "fransac/io/camera_file.hpp"
#include "temporary_folder.h"

namespace fransac::io {
namespace {

using fransac::testing::TemporaryFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const Camera kCamera{640, 480, 517.3, 516.5, 318.6, 255.3, 5000.0};
constexpr const char* kText =
    R"({"width": 640, "height": 480, "fx": 517.3, "fy": 516.5, "cx": 318.6, "cy": 255.3, "depth_scale": 5000.0})";

/// kText with `from` replaced by `to`.
std::string altered(const std::string& from, const std::string& to) {
  std::string text = kText;
  return text.replace(text.find(from), from.size(), to);
}

TEST(CameraFile, ReadsAllFields) {
  const auto camera = parse_camera_file(kText, "camera.json");
  ASSERT_TRUE(camera.ok()) << camera.error().message;
  EXPECT_EQ(camera->camera, kCamera);
  EXPECT_FALSE(camera->lens);
}

TEST(CameraFile, RoundTripIsExact) {
  const Camera camera{1, kMaxImageSide, 0.1 + 0.2, 1e6, -1.0 / 3.0, 2.0 / 3.0 * 1e6, 1000.0000000000001};
  const auto read = parse_camera_file(camera_to_json(camera), "camera.json");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->camera, camera);
}

TEST(CameraFile, DepthScaleDefaultsToMillimetresAndUnknownKeysAreIgnored) {
  const auto camera =
      parse_camera_file(altered(R"("depth_scale": 5000.0)", R"("model": {"fx": "plumb bob"}, "k": [1, 2])"), "camera.json");
  ASSERT_TRUE(camera.ok()) << camera.error().message;
  EXPECT_EQ(camera->camera.depth_scale, 1000.0);
}

TEST(CameraFile, AcceptsAWholeNumberWrittenAsADecimal) {
  const auto camera = parse_camera_file(altered("640", "640.0"), "camera.json");
  ASSERT_TRUE(camera.ok()) << camera.error().message;
  EXPECT_EQ(camera->camera.width, 640);
}

struct Fault {
  std::string text;
  const char* message;  ///< Must be part of the error's message.
};

class CameraFileFault : public ::testing::TestWithParam<Fault> {};

TEST_P(CameraFileFault, IsAFormatErrorThatNamesFileAndField) {
  const auto camera = parse_camera_file(GetParam().text, "some/camera.json");
  ASSERT_FALSE(camera.ok());
  EXPECT_EQ(camera.error().code, ErrorCode::format);
  EXPECT_THAT(camera.error().message, AllOf(StartsWith("some/camera.json:"), HasSubstr(GetParam().message)));
}

INSTANTIATE_TEST_SUITE_P(Missing, CameraFileFault,
                         ::testing::Values(Fault{altered(R"("width": 640, )", ""), R"(field "width" is missing)"},
                                           Fault{altered(R"("height": 480, )", ""), R"(field "height" is missing)"},
                                           Fault{altered(R"("fx": 517.3, )", ""), R"(field "fx" is missing)"},
                                           Fault{altered(R"("fy": 516.5, )", ""), R"(field "fy" is missing)"},
                                           Fault{altered(R"("cx": 318.6, )", ""), R"(field "cx" is missing)"},
                                           Fault{altered(R"("cy": 255.3, )", ""), R"(field "cy" is missing)"}));

INSTANTIATE_TEST_SUITE_P(WrongType, CameraFileFault,
                         ::testing::Values(Fault{altered("640", R"("640")"), R"(field "width" must be a number, not string)"},
                                           Fault{altered("480", "480.5"), R"(field "height" must be a whole number)"},
                                           Fault{altered("517.3", "null"), R"(field "fx" must be a number, not null)"},
                                           Fault{altered("516.5", "true"), R"(field "fy" must be a number, not boolean)"},
                                           Fault{altered("318.6", "[318.6]"), R"(field "cx" must be a number, not array)"},
                                           Fault{altered("5000.0", "{}"),
                                                 R"(field "depth_scale" must be a number, not object)"}));

INSTANTIATE_TEST_SUITE_P(OutOfRange, CameraFileFault,
                         ::testing::Values(Fault{altered("640", "0"), R"("width" must be between 1 and 32768)"},
                                           Fault{altered("640", "-640"), R"("width" must be between)"},
                                           Fault{altered("640", "4294967936"), R"("width" must be between)"},
                                           Fault{altered("640", "18446744073709552256"), R"("width" must be between)"},
                                           Fault{altered("480", "1e300"), R"("height" must be between)"},
                                           Fault{altered("517.3", "0"), R"("fx" must be between)"},
                                           Fault{altered("516.5", "-1"), R"("fy" must be between)"},
                                           Fault{altered("5000.0", "0"), R"("depth_scale" must be between)"},
                                           Fault{altered("318.6", "1e999"), R"(field "cx" holds a number that is out of range)"},
                                           Fault{altered("255.3", "NaN"), R"(field "cy")"},
                                           Fault{altered("255.3", "Infinity"), R"(field "cy")"}));

INSTANTIATE_TEST_SUITE_P(Syntax, CameraFileFault,
                         ::testing::Values(Fault{altered("480, ", R"(480, "width": 641, )"), R"(field "width" appears twice)"},
                                           Fault{std::string(kText) + " garbage", "not valid JSON in line 1"},
                                           Fault{std::string(kText) + kText, "not valid JSON"},
                                           Fault{std::string(kText).substr(0, 40), R"(at or after field "fx")"},
                                           Fault{"{\n\"width\": 640,\n\"height\": ,}", R"(line 3, at or after field "height")"},
                                           Fault{"", "is neither a JSON object nor a YAML mapping"},
                                           Fault{"[640, 480]", "is not a JSON object"},
                                           Fault{"640", "is neither a JSON object nor a YAML mapping"},
                                           Fault{std::string("\0\0", 2), "YAML"},
                                           Fault{"{\"width\": \"\xff\"}", "not valid JSON"}));

TEST(CameraFile, DeepNestingIsOnlyAnError) {
  EXPECT_FALSE(parse_camera_file(std::string(100000, '['), "camera.json").ok());
  EXPECT_FALSE(
      parse_camera_file(R"({"width": )" + std::string(100000, '[') + std::string(100000, ']') + "}", "camera.json").ok());
}

TEST(CameraFile, ReadNamesTheFile) {
  const TemporaryFolder folder;
  const auto file = folder.write("camera.json", altered("640", "0"));
  EXPECT_THAT(read_camera_file(file).error().message, StartsWith(file.string() + ": "));
  EXPECT_EQ(read_camera_file(folder / "none").error().code, ErrorCode::io);
  EXPECT_EQ(read_camera_file(folder.write("good.json", kText))->camera, kCamera);
}

// Each kind of file as its tool writes it, of one camera.
const Camera kMillimetres{640, 480, 517.3, 516.5, 318.6, 255.3, 1000.0};

constexpr const char* kRosCalibration = R"(image_width: 640
image_height: 480
camera_name: rgb_camera
camera_matrix:
  rows: 3
  cols: 3
  data: [517.3, 0, 318.6, 0, 516.5, 255.3, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0, 0, 0, 0, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
)";

constexpr const char* kRosMessage = R"(header:
  stamp:
    sec: 1
    nanosec: 2
  frame_id: camera
height: 480
width: 640
distortion_model: "plumb_bob"
d: [0.0, 0.0, 0.0, 0.0, 0.0]
k:
- 517.3
- 0.0
- 318.6
- 0.0
- 516.5
- 255.3
- 0.0
- 0.0
- 1.0
binning_x: 0
binning_y: 0
roi:
  x_offset: 0
  y_offset: 0
  height: 0
  width: 0
  do_rectify: false
---
height: 1
)";

constexpr const char* kRosJson = R"({"height": 480, "width": 640, "distortion_model": "", "D": [],
  "K": [517.3, 0, 318.6, 0, 516.5, 255.3, 0, 0, 1], "roi": {"width": 640, "height": 480}})";

constexpr const char* kOpen3d =
    R"({"width": 640, "height": 480, "intrinsic_matrix": [517.3, 0, 0, 0, 516.5, 0, 318.6, 255.3, 1]})";

constexpr const char* kRealSense = R"({"width": 640, "height": 480, "fx": 517.3, "fy": 516.5, "ppx": 318.6, "ppy": 255.3,
  "model": "distortion.inverse_brown_conrady", "coeffs": [0, 0, 0, 0, 0]})";

constexpr const char* kOrbSlam = R"(%YAML:1.0
---
# Camera calibration
Camera.fx: 517.3
Camera.fy: 516.5
Camera.cx: 318.6
Camera.cy: 255.3
Camera.k1: 0.0
Camera.p1: -0.0
Camera.width: 640
Camera.height: 480
DepthMapFactor: 5000.0
T: !!opencv-matrix
   rows: 1
   cols: 1
   dt: f
   data: [1.0]
)";

constexpr const char* kOrbSlam3 = R"(%YAML:1.0
File.version: "1.0"
Camera.type: "PinHole"
Camera1.fx: 517.3
Camera1.fy: 516.5
Camera1.cx: 318.6
Camera1.cy: 255.3
Camera.width: 640
Camera.height: 480
RGBD.DepthMapFactor: 5000.0
)";

/// A text with `from` replaced by `to`.
std::string changed(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

std::string nested(const std::string& field) { return "{\"" + field + "\": " + kOpen3d + "}"; }

TEST(CameraFile, ReadsWhatOtherToolsWrite) {
  const std::string trajectory =
      "{\"class_name\": \"PinholeCameraTrajectory\", \"parameters\": [" + nested("intrinsic") + ", " + nested("intrinsic") + "]}";
  for (const std::string& text : {std::string(kRosCalibration), std::string(kRosMessage), std::string(kRosJson),
                                  std::string(kOpen3d), nested("intrinsic"), trajectory, std::string(kRealSense)}) {
    const auto file = parse_camera_file(text, "camera");
    ASSERT_TRUE(file.ok()) << text << file.error().message;
    EXPECT_EQ(file->camera, kMillimetres) << text;
    EXPECT_FALSE(file->lens) << text;
  }
  for (const char* text : {kOrbSlam, kOrbSlam3}) {
    const auto file = parse_camera_file(text, "camera");
    ASSERT_TRUE(file.ok()) << text << file.error().message;
    EXPECT_EQ(file->camera, kCamera) << text;
    EXPECT_FALSE(file->lens) << text;
  }
}

TEST(CameraFile, AYamlOfFieldsIsACameraToo) {
  const auto file = parse_camera_file(
      "\xef\xbb\xbf"
      "width: 640\nheight: 480\nfx: 517.3\nfy: +516.5\ncx: 318.6\ncy: 255.3\ndepth_scale: 5e3\n",
      "camera");
  ASSERT_TRUE(file.ok()) << file.error().message;
  EXPECT_EQ(file->camera, kCamera);
}

TEST(CameraFile, ReadsLenses) {
  struct Case {
    std::string text;
    Lens lens;
  };
  const std::string five = "[0, 0, 0, 0, 0]";
  const std::string eight = "[1, 2, 3, 4, 5, 6, 7, 8]";
  const std::vector<Case> cases{
      {changed(kRosCalibration, five, "[.1, -2e-1, 0.3, 0.4, 0.5]"), {LensModel::plumb_bob, {0.1, -0.2, 0.3, 0.4, 0.5}}},
      {changed(changed(kRosCalibration, five, eight), "plumb_bob", "rational_polynomial"),
       {LensModel::rational_polynomial, {1, 2, 3, 4, 5, 6, 7, 8}}},
      {changed(changed(kRosCalibration, five, eight), "distortion_model: plumb_bob", "remark: none"),
       {LensModel::rational_polynomial, {1, 2, 3, 4, 5, 6, 7, 8}}},
      {changed(changed(kRosMessage, "plumb_bob", "equidistant"), "[0.0, 0.0, 0.0, 0.0, 0.0]", "[1, 2, 3, 4]"),
       {LensModel::equidistant, {1, 2, 3, 4}}},
      {changed(changed(kRosJson, "\"\"", "\"plumb_bob\""), "[]", "[0.5]"), {LensModel::plumb_bob, {0.5}}},
      {changed(changed(kRealSense, "inverse_brown_conrady", "brown_conrady"), five, "[1, 2, 3, 4, 5]"),
       {LensModel::plumb_bob, {1, 2, 3, 4, 5}}},
      {changed(changed(kRealSense, "\"distortion.inverse_brown_conrady\"", "5"), five, "[1, 2, 3, 4, 0]"),
       {LensModel::equidistant, {1, 2, 3, 4}}},
      {changed(kOrbSlam, "k1: 0.0", "k1: 0.25"), {LensModel::plumb_bob, {0.25}}},
      {changed(kOrbSlam, "k1: 0.0", "k6: 0.25"), {LensModel::rational_polynomial, {0, 0, 0, 0, 0, 0, 0, 0.25}}},
      {changed(kOrbSlam3, "\"PinHole\"", "KannalaBrandt8\nCamera1.k1: 0.25"), {LensModel::equidistant, {0.25}}},
  };
  for (const Case& c : cases) {
    const auto file = parse_camera_file(c.text, "some/camera.yaml");
    ASSERT_TRUE(file.ok()) << c.text << file.error().message;
    EXPECT_EQ(file->lens, c.lens) << c.text;
    const auto pinhole = pinhole_of(*file, "some/camera.yaml");
    ASSERT_FALSE(pinhole.ok());
    EXPECT_EQ(pinhole.error().message, "some/camera.yaml: lens distortion (" + std::string(to_string(c.lens.model)) +
                                           ") is not a pinhole's; rectify the depth first");
  }
}

INSTANTIATE_TEST_SUITE_P(
    OtherTools, CameraFileFault,
    ::testing::Values(
        Fault{changed(kRealSense, "[0, 0", "[1, 0"), "lens distortion 'distortion.inverse_brown_conrady' with 5"},
        Fault{changed(changed(kRosCalibration, "plumb_bob", "fov"), "[0, 0,", "[1, 0,"), "lens distortion 'fov'"},
        Fault{changed(kRosCalibration, "[0, 0, 0, 0, 0]", "[0, 0, 0, 0, 0, 1]"), "lens distortion 'plumb_bob' with 6"},
        Fault{changed(kRosCalibration, "[0, 0, 0, 0, 0]", "[0, nan]"),
              R"(field "distortion_coefficients.data" must hold numbers)"},
        Fault{changed(kRosCalibration, "image_width", "width"), R"(field "image_width" is missing)"},
        Fault{changed(kRosCalibration, "0, 318.6, 0", "1, 318.6, 0"),
              R"(field "camera_matrix.data" must hold the numbers fx 0 cx)"},
        Fault{changed(kRosCalibration, "data: [517.3", "dats: [517.3"), R"(field "camera_matrix.data" is missing)"},
        Fault{changed(kRosMessage, "- 0.0\n", ""), R"(field "k" must hold the numbers)"},
        Fault{changed(kRosMessage, "binning_x: 0", "binning_x: 2"), R"(field "binning_x" above 1)"},
        Fault{changed(kRosMessage, "y_offset: 0", "y_offset: 8"), R"(field "roi" other than the whole image)"},
        Fault{changed(kOpen3d, "[517.3, 0, 0,", "[517.3, 0, 318.6,"), R"(field "intrinsic_matrix" must hold the numbers)"},
        Fault{R"({"parameters": []})", R"(field "parameters" holds no camera)"},
        Fault{R"({"parameters": [)" + nested("intrinsic") + ", " + changed(nested("intrinsic"), "640", "641") + "]}",
              R"(field "parameters" holds several cameras)"},
        Fault{changed(kOrbSlam, "Camera.width: 640", ""), R"(field "Camera.width" is missing)"},
        Fault{changed(kOrbSlam, "DepthMapFactor: 5000.0", "DepthMapFactor: 0.001"), R"("depth_scale" must be between)"},
        Fault{"name: nothing\n", "no known camera: neither fx, fy, cx and cy (camera.json) nor camera_matrix"}));

INSTANTIATE_TEST_SUITE_P(Yaml, CameraFileFault,
                         ::testing::Values(Fault{"width: 1\nwidth: 2\n", "2: field 'width' appears twice"},
                                           Fault{"width: &w 1\nheight: *w\n", "2: an alias"},
                                           Fault{"? [a, b]\n: 1\n", "a key that is no text"},
                                           Fault{"width: 640\nheight: [\n", "not valid YAML"},
                                           Fault{"- 1\n- 2\n", "is neither a JSON object nor a YAML mapping"},
                                           Fault{"a: " + std::string(1000, '['), "nesting deeper than 64"}));

TEST(CameraFile, EachPartOfAFileIsAnErrorOrAWholeCamera) {
  for (const std::string text : {kRosCalibration, kRosMessage, kRosJson, kOpen3d, kRealSense, kOrbSlam, kOrbSlam3}) {
    for (std::size_t size = 0; size < text.size(); ++size) {
      const auto file = parse_camera_file(text.substr(0, size), "camera");
      if (file) {
        EXPECT_TRUE(validate(file->camera).ok());
      } else {
        EXPECT_THAT(file.error().message, StartsWith("camera:"));
      }
    }
  }
}

TEST(TumCamera, KnowsTheThreeCamerasByEachName) {
  for (const char* name : {"fr1", "freiburg1", "rgbd_dataset_freiburg1_desk", "fr1_desk", "fr1/desk"})
    EXPECT_EQ(tum_camera(name), kCamera) << name;
  EXPECT_EQ(tum_camera("freiburg2"), (Camera{640, 480, 520.9, 521.0, 325.1, 249.7, 5000.0}));
  EXPECT_EQ(tum_camera("fr3"), (Camera{640, 480, 535.4, 539.2, 320.1, 247.6, 5000.0}));
  for (const char* name : {"", "fr", "fr4", "fr0", "fr12", "freiburg", "freiburg10", "desk", "xfr1"})
    EXPECT_FALSE(tum_camera(name)) << name;
}

TEST(CameraPreset, KnowsKinectAndTheCamerasOfTum) {
  EXPECT_EQ(camera_preset("kinect1"), (Camera{640, 480, 525.0, 525.0, 319.5, 239.5, 1000.0}));
  EXPECT_EQ(camera_preset("fr1"), kCamera);
  for (const char* name : {"", "kinect", "kinect12", "kinect1.json"}) EXPECT_FALSE(camera_preset(name)) << name;
}

}  // namespace
}  // namespace fransac::io

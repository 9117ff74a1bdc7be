// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <limits>
#include <string>

#include "fransac/io/camera_json.hpp"
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

TEST(CameraJson, ReadsAllFields) {
  const auto camera = parse_camera_json(kText, "camera.json");
  ASSERT_TRUE(camera.ok()) << camera.error().message;
  EXPECT_EQ(*camera, kCamera);
}

TEST(CameraJson, RoundTripIsExact) {
  const Camera camera{1, kMaxImageSide, 0.1 + 0.2, 1e6, -1.0 / 3.0, 2.0 / 3.0 * 1e6, 1000.0000000000001};
  const auto read = parse_camera_json(camera_to_json(camera), "camera.json");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(*read, camera);
}

TEST(CameraJson, DepthScaleDefaultsToMillimetresAndUnknownKeysAreIgnored) {
  const auto camera =
      parse_camera_json(altered(R"("depth_scale": 5000.0)", R"("model": {"fx": "plumb bob"}, "k": [1, 2])"), "camera.json");
  ASSERT_TRUE(camera.ok()) << camera.error().message;
  EXPECT_EQ(camera->depth_scale, 1000.0);
}

TEST(CameraJson, AcceptsAWholeNumberWrittenAsADecimal) {
  const auto camera = parse_camera_json(altered("640", "640.0"), "camera.json");
  ASSERT_TRUE(camera.ok()) << camera.error().message;
  EXPECT_EQ(camera->width, 640);
}

struct Fault {
  std::string text;
  const char* message;  ///< Must be part of the error's message.
};

class CameraJsonFault : public ::testing::TestWithParam<Fault> {};

TEST_P(CameraJsonFault, IsAFormatErrorThatNamesFileAndField) {
  const auto camera = parse_camera_json(GetParam().text, "some/camera.json");
  ASSERT_FALSE(camera.ok());
  EXPECT_EQ(camera.error().code, ErrorCode::format);
  EXPECT_THAT(camera.error().message, AllOf(StartsWith("some/camera.json: "), HasSubstr(GetParam().message)));
}

INSTANTIATE_TEST_SUITE_P(Missing, CameraJsonFault,
                         ::testing::Values(Fault{altered(R"("width": 640, )", ""), R"(field "width" is missing)"},
                                           Fault{altered(R"("height": 480, )", ""), R"(field "height" is missing)"},
                                           Fault{altered(R"("fx": 517.3, )", ""), R"(field "fx" is missing)"},
                                           Fault{altered(R"("fy": 516.5, )", ""), R"(field "fy" is missing)"},
                                           Fault{altered(R"("cx": 318.6, )", ""), R"(field "cx" is missing)"},
                                           Fault{altered(R"("cy": 255.3, )", ""), R"(field "cy" is missing)"}));

INSTANTIATE_TEST_SUITE_P(WrongType, CameraJsonFault,
                         ::testing::Values(Fault{altered("640", R"("640")"), R"(field "width" must be a number, not string)"},
                                           Fault{altered("480", "480.5"), R"(field "height" must be a whole number)"},
                                           Fault{altered("517.3", "null"), R"(field "fx" must be a number, not null)"},
                                           Fault{altered("516.5", "true"), R"(field "fy" must be a number, not boolean)"},
                                           Fault{altered("318.6", "[318.6]"), R"(field "cx" must be a number, not array)"},
                                           Fault{altered("5000.0", "{}"),
                                                 R"(field "depth_scale" must be a number, not object)"}));

INSTANTIATE_TEST_SUITE_P(OutOfRange, CameraJsonFault,
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

INSTANTIATE_TEST_SUITE_P(Syntax, CameraJsonFault,
                         ::testing::Values(Fault{altered("480, ", R"(480, "width": 641, )"), R"(field "width" appears twice)"},
                                           Fault{std::string(kText) + " garbage", "not valid JSON in line 1"},
                                           Fault{std::string(kText) + kText, "not valid JSON"},
                                           Fault{std::string(kText).substr(0, 40), R"(at or after field "fx")"},
                                           Fault{"{\n\"width\": 640,\n\"height\": ,}", R"(line 3, at or after field "height")"},
                                           Fault{"", "not valid JSON"}, Fault{"[640, 480]", "is not a JSON object"},
                                           Fault{"640", "is not a JSON object"}, Fault{std::string("\0\0", 2), "not valid JSON"},
                                           Fault{"{\"width\": \"\xff\"}", "not valid JSON"}));

TEST(CameraJson, DeepNestingIsOnlyAnError) {
  EXPECT_FALSE(parse_camera_json(std::string(100000, '['), "camera.json").ok());
  EXPECT_FALSE(
      parse_camera_json(R"({"width": )" + std::string(100000, '[') + std::string(100000, ']') + "}", "camera.json").ok());
}

TEST(CameraJson, ReadNamesTheFile) {
  const TemporaryFolder folder;
  const auto file = folder.write("camera.json", altered("640", "0"));
  EXPECT_THAT(read_camera_json(file).error().message, StartsWith(file.string() + ": "));
  EXPECT_EQ(read_camera_json(folder / "none").error().code, ErrorCode::io);
  EXPECT_EQ(*read_camera_json(folder.write("good.json", kText)), kCamera);
}

TEST(TumCamera, KnowsTheThreeCamerasByEachName) {
  for (const char* name : {"fr1", "freiburg1", "rgbd_dataset_freiburg1_desk", "fr1_desk", "fr1/desk"})
    EXPECT_EQ(tum_camera(name), kCamera) << name;
  EXPECT_EQ(tum_camera("freiburg2"), (Camera{640, 480, 520.9, 521.0, 325.1, 249.7, 5000.0}));
  EXPECT_EQ(tum_camera("fr3"), (Camera{640, 480, 535.4, 539.2, 320.1, 247.6, 5000.0}));
  for (const char* name : {"", "fr", "fr4", "fr0", "fr12", "freiburg", "freiburg10", "desk", "xfr1"})
    EXPECT_FALSE(tum_camera(name)) << name;
}

}  // namespace
}  // namespace fransac::io

// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <numbers>
#include <string>

#include "fransac/io/camera_file.hpp"
#include "fransac/io/dataset.hpp"
#include "fransac/io/file.hpp"
#include "temporary_folder.h"

namespace fransac::io {
namespace {

namespace fs = std::filesystem;
using fransac::testing::read_text;
using fransac::testing::TemporaryFolder;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const Camera kCamera{4, 3, 500.0, 501.0, 1.5, 1.0, 5000.0};
const DepthImage kDepth{4, 3, 1, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 65535}};
const LabelImage kLabels{4, 3, 1, {0, 0, 1, 1, 1, 2, 2, 255, 255, 255, 255, 1}};

const ObjectImage kObjects{4, 3, 1, {0, 0, 0, 0, 7, 7, 7, 0, 0, 1, 0, 0}};

FrameToWrite whole_frame() {
  FrameToWrite frame;
  frame.camera = kCamera;
  frame.depth = kDepth;
  frame.labels = kLabels;
  frame.objects = kObjects;
  frame.colour = ColourImage{4, 3, 3, std::vector<std::uint8_t>(36, 77)};
  frame.true_planes.emplace_back(1, *make_plane({0.1, -0.2, -1.0}, 1.5));
  frame.true_planes.emplace_back(2, *make_plane({0.0, -1.0, 0.0}, 0.7));
  return frame;
}

void write_depth(const fs::path& file) {
  fs::create_directories(file.parent_path());
  ASSERT_TRUE(write_png(file, kDepth).ok());
}

std::vector<std::string> frame_names(const Dataset& dataset) {
  std::vector<std::string> names;
  for (const FrameFiles& frame : dataset.frames) names.push_back(frame.name);
  return names;
}

TEST(DetectKind, FindsEachKindFromTheContent) {
  const TemporaryFolder folder;
  write_depth(folder / "a/no_extension");
  EXPECT_EQ(*detect_kind(folder / "a/no_extension"), InputKind::depth_image);
  EXPECT_EQ(*detect_kind(folder / "a"), InputKind::dataset);
  EXPECT_EQ(*detect_kind(folder.write("1.png", "# .PCD v0.7 - Point Cloud Data\n")), InputKind::pcd);
  EXPECT_EQ(*detect_kind(folder.write("2.png", "# made by a scanner\n\nVERSION 0.7\n")), InputKind::pcd);
  EXPECT_EQ(*detect_kind(folder.write("3.pcd", "ply\nformat ascii 1.0\n")), InputKind::ply);
  EXPECT_EQ(*detect_kind(folder.write("4.pcd", "ply\r\nformat ascii 1.0\r\n")), InputKind::ply);
  write_depth(folder / "frame/depth.png");
  EXPECT_EQ(*detect_kind(folder / "frame"), InputKind::frame);
  write_depth(folder / "set/one/depth.png");
  EXPECT_EQ(*detect_kind(folder / "set"), InputKind::dataset);
  folder.write("tum/depth.txt", "");
  EXPECT_EQ(*detect_kind(folder / "tum"), InputKind::tum_sequence);
  folder.write("named/dataset.json", "{}");
  EXPECT_EQ(*detect_kind(folder / "named"), InputKind::dataset);
}

TEST(DetectKind, FallsBackToTheName) {
  const TemporaryFolder folder;
  EXPECT_EQ(*detect_kind(folder.write("a.PNG", "")), InputKind::depth_image);
  EXPECT_EQ(*detect_kind(folder.write("a.pcd", "FIELDS x y z")), InputKind::pcd);
  EXPECT_EQ(*detect_kind(folder.write("a.Ply", "plyx")), InputKind::ply);
}

TEST(DetectKind, SaysWhatIsNoInput) {
  const TemporaryFolder folder;
  EXPECT_EQ(detect_kind(folder / "none").error().message, (folder / "none").string() + ": No such file or directory");
  EXPECT_EQ(detect_kind(folder / "none").error().code, ErrorCode::io);
  const auto text = folder.write("notes.txt", "VERSIONS of things");
  EXPECT_EQ(detect_kind(text).error().message,
            text.string() + ": neither a depth image (PNG, TIFF, PGM, NPY) nor a PCD, PLY or XYZ file");
  EXPECT_EQ(detect_kind(text).error().code, ErrorCode::format);
  EXPECT_THAT(detect_kind(folder.path()).error().message, AllOf(HasSubstr(folder.path().string()), HasSubstr("depth.txt")));
  EXPECT_EQ(detect_kind(folder.path()).error().code, ErrorCode::format);
  EXPECT_EQ(detect_kind("").error().code, ErrorCode::io);
  EXPECT_EQ(detect_kind(std::string(5000, 'x')).error().code, ErrorCode::io);
}

TEST(DetectKind, DoesNotWaitForAPipe) {
  const TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(detect_kind(folder / "pipe").error().code, ErrorCode::format);
}

TEST(DetectKind, IgnoresPicturesThatAreNoDepth) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_png(folder / "a.png", kLabels).ok());
  EXPECT_FALSE(detect_kind(folder.path()).ok());
}

TEST(Frame, RoundTripKeepsEverything) {
  const TemporaryFolder folder;
  const FrameToWrite written = whole_frame();
  ASSERT_TRUE(write_frame(folder / "new/scene", written).ok());
  const auto dataset = list_frames(folder / "new/scene");
  ASSERT_TRUE(dataset.ok()) << dataset.error().message;
  EXPECT_EQ(dataset->kind, InputKind::frame);
  EXPECT_EQ(dataset->name, "scene");
  EXPECT_EQ(dataset->truth, Truth::planes);
  ASSERT_THAT(frame_names(*dataset), ElementsAre("scene"));
  EXPECT_EQ(dataset->frames[0].colour, folder / "new/scene/rgb.png");

  const auto frame = load_frame(dataset->frames[0]);
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame->name, "scene");
  EXPECT_EQ(frame->camera, kCamera);
  EXPECT_EQ(frame->depth.pixels, kDepth.pixels);
  EXPECT_EQ(frame->labels->pixels, kLabels.pixels);
  EXPECT_EQ(frame->objects->pixels, kObjects.pixels);
  EXPECT_FLOAT_EQ(frame->view().metres(3, 2), 65535.0F / 5000.0F);
  ASSERT_EQ(frame->true_planes.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(frame->true_planes[i].first, written.true_planes[i].first);
    EXPECT_LT((frame->true_planes[i].second.normal - written.true_planes[i].second.normal).norm(), 1e-15);
    EXPECT_DOUBLE_EQ(frame->true_planes[i].second.d, written.true_planes[i].second.d);
  }
}

TEST(Frame, IsLoadedIntoTheMemoryOfTheLast) {
  const TemporaryFolder folder;
  FrameToWrite written = whole_frame();
  ASSERT_TRUE(write_frame(folder / "1", written).ok());
  std::reverse(written.depth.pixels.begin(), written.depth.pixels.end());
  written.labels = {};
  written.objects = {};
  written.true_planes = {};
  ASSERT_TRUE(write_frame(folder / "2", written).ok());
  const auto dataset = list_frames(folder.path());
  ASSERT_TRUE(dataset.ok()) << dataset.error().message;
  LoadWorkspace workspace;
  Frame frame;
  ASSERT_TRUE(load_frame(dataset->frames[0], std::nullopt, workspace, frame).ok());
  EXPECT_TRUE(frame.labels && frame.objects && !frame.true_planes.empty());
  const auto* const memory = frame.depth.pixels.data();
  ASSERT_TRUE(load_frame(dataset->frames[1], std::nullopt, workspace, frame).ok());
  EXPECT_EQ(frame.depth.pixels.data(), memory);
  EXPECT_EQ(frame.depth.pixels, written.depth.pixels);
  EXPECT_FALSE(frame.labels || frame.objects || !frame.true_planes.empty());
}

TEST(Frame, TruthCountsPixelsThatHaveDepth) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_frame(folder.path(), whole_frame()).ok());
  const std::string text = read_text(folder / "truth.json");
  EXPECT_THAT(text, AllOf(HasSubstr(R"("pixels": 4)"), HasSubstr(R"("pixels": 2)"), HasSubstr(R"("nonplane_pixels": 4)"),
                          HasSubstr(R"("ignored_pixels": 1)"), HasSubstr(R"("valid_pixels": 11)")));
}

TEST(Frame, TruthTellsObjectsAndWhereTheCameraIs) {
  const TemporaryFolder folder;
  FrameToWrite frame = whole_frame();
  frame.label_scope = LabelScope::sequence;
  frame.T_world_camera = Eigen::Translation3d(1.5, -2.5, 0.25) * Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());
  TrueObject object;
  object.id = 7;
  object.box.size = {0.5, 0.25, 0.125};
  object.box.centre = {1.0, 2.0, 4.0};
  frame.true_objects.push_back(object);
  object.id = 8;
  object.support = make_plane({0.0, -1.0, 0.0}, 0.75);
  object.lowest_m = 0.5;
  object.highest_m = 0.625;
  frame.true_objects.push_back(object);
  ASSERT_TRUE(write_frame(folder.path(), frame).ok());
  std::string text = read_text(folder / "truth.json");
  std::erase_if(text, [](char c) { return c == ' ' || c == '\n'; });
  EXPECT_THAT(text, HasSubstr(R"({"labels_hold_for":"sequence","pose":{"translation":[1.5,-2.5,0.25],"quaternion":[1.0,)"));
  EXPECT_THAT(text,
              HasSubstr(R"({"id":7,"pixels":3,"box":{"centre":[1.0,2.0,4.0],"size":[0.5,0.25,0.125],"along":[1.0,0.0,0.0],)"));
  EXPECT_THAT(text, HasSubstr(R"("yaw_rad":1.5707963267948966},"support":null,"height_range_m":null})"));
  EXPECT_THAT(text, HasSubstr(R"({"id":8,"pixels":0,)"));
  EXPECT_THAT(text, HasSubstr(R"("support":{"normal":[0.0,-1.0,0.0],"d":0.75},"height_range_m":[0.5,0.625]})"));
  EXPECT_TRUE(load_frame(list_frames(folder.path())->frames[0]).ok());
}

TEST(Frame, NothingIsWrittenWhenAPartDoesNotFit) {
  const TemporaryFolder folder;
  FrameToWrite frame = whole_frame();
  frame.labels->width = 3;
  const Status status = write_frame(folder / "scene", frame);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::invalid_argument);
  EXPECT_FALSE(fs::exists(folder / "scene"));
  frame = whole_frame();
  frame.camera.fx = 0.0;
  EXPECT_THAT(write_frame(folder / "scene", frame).error().message, HasSubstr("\"fx\""));
  folder.write("file", "");
  EXPECT_EQ(write_frame(folder / "file/scene", whole_frame()).error().code, ErrorCode::io);
}

TEST(Frame, TruthMayHaveTheCameraOnEitherSide) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_frame(folder.path(), whole_frame()).ok());
  folder.write("truth.json", R"({"planes": [{"label": 7, "name": "floor", "normal": [0, 3, 4], "d": -10}]})");
  const auto frame = load_frame(list_frames(folder.path())->frames[0]);
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  ASSERT_EQ(frame->true_planes.size(), 1U);
  EXPECT_EQ(frame->true_planes[0].first, 7);
  EXPECT_EQ(frame->true_planes[0].second.normal, Eigen::Vector3d(0.0, -0.6, -0.8));
  EXPECT_EQ(frame->true_planes[0].second.d, 2.0);
}

TEST(Frame, FaultsOfTruthNameFileAndField) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_frame(folder.path(), whole_frame()).ok());
  const std::string good = R"({"label": 1, "normal": [0, 0, 1], "d": -1})";
  const std::pair<std::string, std::string> faults[] = {
      {"{}", R"(field "planes" is missing)"},
      {R"({"planes": 3})", R"(field "planes" must be an array)"},
      {R"({"planes": [)" + good + ", 4]}", R"(field "planes[1]" must be an object)"},
      {R"({"planes": [{"normal": [0, 0, 1], "d": 1}]})", R"(field "planes[0].label" is missing)"},
      {R"({"planes": [{"label": 255, "normal": [0, 0, 1], "d": 1}]})", R"(field "planes[0].label" must be between 1 and 254)"},
      {R"({"planes": [{"label": 0, "normal": [0, 0, 1], "d": 1}]})", R"(field "planes[0].label" must be between 1 and 254)"},
      {R"({"planes": [{"label": 1, "d": 1}]})", R"(field "planes[0].normal" is missing)"},
      {R"({"planes": [{"label": 1, "normal": [0, 1], "d": 1}]})", R"(field "planes[0].normal" must be three numbers)"},
      {R"({"planes": [{"label": 1, "normal": [0, 1, "2"], "d": 1}]})", R"(field "planes[0].normal" must be three numbers)"},
      {R"({"planes": [{"label": 1, "normal": [0, 0, 0], "d": 1}]})", R"(field "planes[0].normal" is no direction)"},
      {R"({"planes": [{"label": 1, "normal": [0, 0, 1]}]})", R"(field "planes[0].d" is missing)"},
      {R"({"planes": [)" + good + "," + good + "]}", R"(field "planes[1].label" appears twice)"},
  };
  for (const auto& [text, message] : faults) {
    const auto file = folder.write("truth.json", text);
    const auto frame = load_frame(list_frames(folder.path())->frames[0]);
    ASSERT_FALSE(frame.ok()) << text;
    EXPECT_EQ(frame.error().message, file.string() + ": " + message);
  }
}

TEST(Frame, ACameraFileGivenOverridesTheOneBeside) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_frame(folder.path(), whole_frame()).ok());
  Camera other = kCamera;
  other.fx = 123.0;
  const auto file = folder.write("other.json", camera_to_json(other));
  EXPECT_EQ(load_frame(list_frames(folder.path())->frames[0], file)->camera.fx, 123.0);
}

TEST(Frame, WithoutACameraTheErrorNamesImageAndCameraFile) {
  const TemporaryFolder folder;
  write_depth(folder / "depth.png");
  const auto frame = load_frame(list_frames(folder / "depth.png")->frames[0]);
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.error().code, ErrorCode::no_data);
  EXPECT_THAT(frame.error().message,
              AllOf(HasSubstr((folder / "depth.png").string()), HasSubstr((folder / "camera.json").string())));
}

TEST(Frame, SizesThatDoNotMatchNameBothFiles) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_frame(folder.path(), whole_frame()).ok());
  const FrameFiles files = list_frames(folder.path())->frames[0];
  ASSERT_TRUE(write_png(folder / "labels.png", LabelImage{2, 1, 1, {0, 1}}).ok());
  EXPECT_EQ(load_frame(files).error().message,
            (folder / "labels.png").string() + ": has 2x1 pixels, but " + (folder / "depth.png").string() + " has 4x3");
  ASSERT_TRUE(write_png(folder / "depth.png", DepthImage{2, 1, 1, {0, 1}}).ok());
  EXPECT_EQ(load_frame(files).error().message, (folder / "camera.json").string() + ": the camera is for 4x3 pixels, but " +
                                                   (folder / "depth.png").string() + " has 2x1");
}

TEST(Frame, ObjectsMayHaveSixteenBits) {
  const TemporaryFolder folder;
  FrameToWrite frame = whole_frame();
  frame.objects->pixels[3] = 300;
  ASSERT_TRUE(write_frame(folder / "scene", frame).ok());
  EXPECT_TRUE(read_depth_png(folder / "scene/objects.png").ok());
  const auto dataset = list_frames(folder / "scene");
  ASSERT_TRUE(dataset.ok());
  EXPECT_EQ(load_frame(dataset->frames[0])->objects->pixels, frame.objects->pixels);
  fs::remove(folder / "scene/objects.png");
  EXPECT_FALSE(load_frame(list_frames(folder / "scene")->frames[0])->objects.has_value());
}

TEST(Frame, ObjectsOfAnotherSizeOrKindAreAnErrorThatNamesThem) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_frame(folder.path(), whole_frame()).ok());
  const auto message = [&] { return load_frame(list_frames(folder.path())->frames[0]).error().message; };
  ASSERT_TRUE(write_png(folder / "objects.png", LabelImage{2, 1, 1, {0, 1}}).ok());
  EXPECT_THAT(message(), AllOf(HasSubstr((folder / "objects.png").string()), HasSubstr("2x1")));
  ASSERT_TRUE(write_png(folder / "objects.png", ColourImage{4, 3, 3, std::vector<std::uint8_t>(36)}).ok());
  EXPECT_THAT(message(),
              AllOf(HasSubstr((folder / "objects.png").string()), HasSubstr("8-bit RGB PNG, not an image of object ids")));
}

TEST(Frame, RegionsLieInGtSegAndMayBeMissing) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_frame(folder.path(), whole_frame()).ok());
  EXPECT_FALSE(load_frame(list_frames(folder.path())->frames[0])->regions.has_value());
  const LabelImage regions{4, 3, 1, {0, 9, 10, 10, 11, 11, 8, 8, 255, 255, 10, 10}};
  ASSERT_TRUE(write_png(folder / "gt_seg.png", regions).ok());
  const FrameFiles files = list_frames(folder.path())->frames[0];
  EXPECT_EQ(files.regions, folder / "gt_seg.png");
  const auto frame = load_frame(files);
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame->regions->pixels, regions.pixels);
  ASSERT_TRUE(write_png(folder / "gt_seg.png", LabelImage{2, 1, 1, {0, 1}}).ok());
  EXPECT_THAT(load_frame(files).error().message, AllOf(HasSubstr((folder / "gt_seg.png").string()), HasSubstr("2x1")));
}

TEST(Frame, TheFloorIsWhatTruthSaysElseTheDataset) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_frame(folder / "set/scene", whole_frame()).ok());
  const auto floor = [&] { return load_frame(list_frames(folder / "set")->frames[0])->floor; };
  EXPECT_EQ(floor(), std::nullopt);
  folder.write("set/dataset.json", R"({"truth": "planes", "floor": 3})");
  EXPECT_EQ(floor(), 3);
  folder.write("set/scene/truth.json", R"({"planes": [], "floor": 254})");
  EXPECT_EQ(floor(), 254);
  folder.write("set/scene/truth.json", R"({"planes": [], "floor": null})");
  EXPECT_EQ(floor(), 0);
  folder.write("set/scene/truth.json", R"({"planes": []})");
  EXPECT_EQ(floor(), 3);
}

TEST(Frame, TheFloorIsWrittenAndReadAgain) {
  const TemporaryFolder folder;
  FrameToWrite frame = whole_frame();
  for (const std::optional<int> floor : {std::optional<int>(), std::optional<int>(0), std::optional<int>(7)}) {
    frame.floor = floor;
    ASSERT_TRUE(write_frame(folder.path(), frame).ok());
    EXPECT_EQ(load_frame(list_frames(folder.path())->frames[0])->floor, floor);
  }
}

TEST(Frame, AFloorThatIsNoLabelNamesFileAndField) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_frame(folder / "set/scene", whole_frame()).ok());
  const auto truth = folder.write("set/scene/truth.json", R"({"planes": [], "floor": 255})");
  EXPECT_EQ(load_frame(list_frames(folder / "set")->frames[0]).error().message,
            truth.string() + ": field \"floor\" must be between 1 and 254");
  const auto dataset = folder.write("set/dataset.json", R"({"truth": "planes", "floor": "floor"})");
  EXPECT_EQ(list_frames(folder / "set").error().message, dataset.string() + ": field \"floor\" must be a number, not string");
}

TEST(DepthPng, TakesWhatLiesBesideIt) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_frame(folder / "set/scene", whole_frame()).ok());
  ASSERT_TRUE(write_dataset_json(folder / "set", Truth::dominant, "structured_light").ok());
  const auto dataset = list_frames(folder / "set/scene/depth.png");
  ASSERT_TRUE(dataset.ok()) << dataset.error().message;
  EXPECT_EQ(dataset->kind, InputKind::depth_image);
  EXPECT_EQ(dataset->truth, Truth::dominant);
  EXPECT_EQ(dataset->sensor, "structured_light");
  ASSERT_THAT(frame_names(*dataset), ElementsAre("scene"));
  const FrameFiles& files = dataset->frames[0];
  EXPECT_EQ(files.camera_file, folder / "set/scene/camera.json");
  EXPECT_EQ(files.labels, folder / "set/scene/labels.png");
  EXPECT_EQ(files.truth, folder / "set/scene/truth.json");
  EXPECT_EQ(files.colour, folder / "set/scene/rgb.png");
}

TEST(DepthPng, OneOfManyHasOnlyTheCamera) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_frame(folder.path(), whole_frame()).ok());
  fs::rename(folder / "depth.png", folder / "first.png");
  EXPECT_TRUE(list_frames(folder / "first.png")->frames[0].labels.has_value());
  write_depth(folder / "second.png");
  const auto dataset = list_frames(folder / "second.png");
  ASSERT_THAT(frame_names(*dataset), ElementsAre("second"));
  EXPECT_FALSE(dataset->frames[0].labels.has_value());
  EXPECT_FALSE(dataset->frames[0].colour.has_value());
  EXPECT_EQ(dataset->frames[0].camera_file, folder / "camera.json");
}

TEST(Dataset, ListsFrameFoldersByName) {
  const TemporaryFolder folder;
  for (const char* name : {"b", "a", "c"}) ASSERT_TRUE(write_frame(folder / name, whole_frame()).ok());
  fs::create_directories(folder / "empty");
  ASSERT_TRUE(write_dataset_json(folder.path(), Truth::planes, "").ok());
  const auto dataset = list_frames(folder.path() / "");
  ASSERT_TRUE(dataset.ok()) << dataset.error().message;
  EXPECT_EQ(dataset->name, folder.path().filename());
  EXPECT_EQ(dataset->truth, Truth::planes);
  EXPECT_EQ(dataset->sensor, "");
  EXPECT_THAT(frame_names(*dataset), ElementsAre("a", "b", "c"));
}

TEST(Dataset, ListsDepthPngsAndLeavesOtherPicturesOut) {
  const TemporaryFolder folder;
  for (const char* name : {"2.png", "1.png"}) write_depth(folder / name);
  ASSERT_TRUE(write_png(folder / "0.png", kLabels).ok());
  folder.write("camera.json", camera_to_json(kCamera));
  const auto dataset = list_frames(folder.path());
  ASSERT_TRUE(dataset.ok()) << dataset.error().message;
  EXPECT_THAT(frame_names(*dataset), ElementsAre("1", "2"));
  EXPECT_EQ(dataset->truth, Truth::none);
  EXPECT_EQ(load_frame(dataset->frames[1])->camera, kCamera);
}

TEST(Dataset, WithoutAFrameThereIsNoData) {
  const TemporaryFolder folder;
  folder.write("dataset.json", "{}");
  EXPECT_EQ(list_frames(folder.path()).error().code, ErrorCode::no_data);
  folder.write("tum/depth.txt", "# nothing\n");
  EXPECT_EQ(list_frames(folder / "tum").error().code, ErrorCode::no_data);
  EXPECT_EQ(list_frames(folder / "tum").error().message, (folder / "tum").string() + ": holds no frame");
}

TEST(Dataset, ACloudHasNoFrames) {
  const TemporaryFolder folder;
  const auto cloud = folder.write("a.ply", "ply\n");
  EXPECT_EQ(list_frames(cloud).error().code, ErrorCode::invalid_argument);
  EXPECT_THAT(list_frames(cloud).error().message, HasSubstr(cloud.string()));
}

TEST(Dataset, FaultsOfDatasetJsonNameFileAndField) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_frame(folder / "a", whole_frame()).ok());
  const auto file = folder.write("dataset.json", R"({"truth": "all"})");
  EXPECT_EQ(list_frames(folder.path()).error().message,
            file.string() + R"(: field "truth" must be "none", "dominant" or "planes")");
  folder.write("dataset.json", R"({"truth": "none", "sensor": 3})");
  EXPECT_EQ(list_frames(folder.path()).error().message, file.string() + R"(: field "sensor" must be a string, not number)");
}

TEST(Dataset, JsonRoundTrip) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_frame(folder / "a", whole_frame()).ok());
  for (const Truth truth : {Truth::none, Truth::dominant, Truth::planes}) {
    ASSERT_TRUE(write_dataset_json(folder.path(), truth, "stereo \"x\"").ok());
    EXPECT_EQ(list_frames(folder.path())->truth, truth);
    EXPECT_EQ(list_frames(folder.path())->sensor, "stereo \"x\"");
  }
  EXPECT_FALSE(write_dataset_json(folder.path(), Truth::none, "\xff").ok());
  EXPECT_EQ(list_frames(folder.path())->truth, Truth::planes);
}

TEST(Tum, ListsByTimeWithPicturesAndPublishedCamera) {
  const TemporaryFolder folder;
  const fs::path sequence = "rgbd_dataset_freiburg2_desk";
  folder.write(sequence / "depth.txt", "# depth\n20.5 depth/20.5.png\n10.5 depth/10.5.png\n");
  folder.write(sequence / "rgb.txt", "10.51 rgb/a.png\n20.53 rgb/b.png\n");
  write_depth(folder / sequence / "depth/10.5.png");
  const auto dataset = list_frames(folder / sequence);
  ASSERT_TRUE(dataset.ok()) << dataset.error().message;
  EXPECT_EQ(dataset->kind, InputKind::tum_sequence);
  ASSERT_THAT(frame_names(*dataset), ElementsAre("10.5", "20.5"));
  EXPECT_EQ(dataset->frames[0].colour, folder / sequence / "rgb/a.png");
  EXPECT_EQ(dataset->frames[1].colour, std::nullopt);
  EXPECT_EQ(dataset->frames[0].timestamp_s, 10.5);
  EXPECT_EQ(dataset->frames[0].camera, tum_camera("fr2"));
  EXPECT_EQ(list_frames(folder / sequence / "depth/10.5.png")->frames[0].camera, tum_camera("fr2"));
}

TEST(Load, ScalesKnownCamerasToTheImage) {
  const TemporaryFolder folder;
  write_depth(folder / "depth.png");
  FrameFiles files = list_frames(folder / "depth.png")->frames[0];
  files.camera = Camera{8, 6, 10.0, 12.0, 3.5, 2.0, 5000.0};
  const auto frame = load_frame(files);
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame->camera, (Camera{4, 3, 5.0, 6.0, 1.5, 0.75, 5000.0}));
  files.camera->width = 9;
  EXPECT_THAT(load_frame(files).error().message, HasSubstr("the camera is for 9x6 pixels, but"));
}

TEST(Tum, FoldersOfFramesKeepTheirTruth) {
  const TemporaryFolder folder;
  FrameToWrite frame = whole_frame();
  ASSERT_TRUE(write_frame(folder / "run/b", frame).ok());
  frame.camera.fx = 321.0;
  ASSERT_TRUE(write_frame(folder / "run/a", frame).ok());
  write_depth(folder / "run/depth.png");  // not in a folder of its own: labels beside it are not its own
  ASSERT_TRUE(write_png(folder / "run/labels.png", kLabels).ok());
  folder.write("run/depth.txt", "0.1 a/depth.png\n0.0 b/depth.png\n0.2 depth.png\n");
  folder.write("run/camera.json", camera_to_json(kCamera));
  folder.write("run/dataset.json", R"({"truth": "planes", "sensor": "stereo"})");
  const auto dataset = list_frames(folder / "run");
  ASSERT_TRUE(dataset.ok()) << dataset.error().message;
  EXPECT_EQ(dataset->kind, InputKind::tum_sequence);
  EXPECT_EQ(dataset->truth, Truth::planes);
  EXPECT_EQ(dataset->sensor, "stereo");
  EXPECT_THAT(frame_names(*dataset), ElementsAre("0.0", "0.1", "0.2"));
  const auto first = load_frame(dataset->frames[1]);
  ASSERT_TRUE(first.ok()) << first.error().message;
  EXPECT_EQ(first->camera.fx, 321.0);
  EXPECT_EQ(first->labels->pixels, kLabels.pixels);
  EXPECT_EQ(first->objects->pixels, kObjects.pixels);
  EXPECT_EQ(first->true_planes.size(), 2U);
  EXPECT_EQ(dataset->frames[1].colour, folder / "run/a/rgb.png");
  const auto last = load_frame(dataset->frames[2]);
  ASSERT_TRUE(last.ok()) << last.error().message;
  EXPECT_FALSE(last->labels.has_value());
}

TEST(Tum, AssociationsAloneMakeASequence) {
  const TemporaryFolder folder;
  const fs::path sequence =
      folder.write("fr1/associations.txt", "2.5 rgb/b.png 2.51 depth/b.png\n1.5 rgb/a.png 1.51 depth/a.png\n").parent_path();
  write_depth(sequence / "depth/a.png");
  EXPECT_EQ(*detect_kind(sequence), InputKind::tum_sequence);
  const auto dataset = list_frames(sequence);
  ASSERT_TRUE(dataset.ok()) << dataset.error().message;
  EXPECT_THAT(frame_names(*dataset), ElementsAre("1.51", "2.51"));
  EXPECT_EQ(dataset->frames[0].depth, sequence / "depth/a.png");
  EXPECT_EQ(dataset->frames[0].colour, sequence / "rgb/a.png");
  EXPECT_EQ(dataset->frames[0].camera, tum_camera("fr1"));
  EXPECT_THAT(dataset->files, ElementsAre(sequence / "associations.txt"));
  EXPECT_EQ(list_frames(sequence / "depth/a.png")->frames[0].camera, tum_camera("fr1"));
  folder.write("fr1/depth.txt", "7 depth/a.png\n");
  EXPECT_THAT(frame_names(*list_frames(sequence)), ElementsAre("7"));
}

TEST(Frame, CameraMayBeAYaml) {
  const TemporaryFolder folder;
  write_depth(folder / "depth.png");
  folder.write("camera.yaml", "width: 4\nheight: 3\nK: [500.0, 0, 1.5, 0, 501.0, 1.0, 0, 0, 1]\ndepth_scale: 5000\n");
  const auto frame = load_frame(list_frames(folder.path())->frames[0]);
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame->camera, kCamera);
}

TEST(Tum, CameraJsonGoesBeforeTheName) {
  const TemporaryFolder folder;
  folder.write("fr1/depth.txt", "1 depth/1.png\n");
  folder.write("fr1/camera.json", camera_to_json(kCamera));
  write_depth(folder / "fr1/depth/1.png");
  EXPECT_EQ(load_frame(list_frames(folder / "fr1")->frames[0])->camera, kCamera);
}

TEST(Tum, WorksWithoutPicturesAndRefusesBadLists) {
  const TemporaryFolder folder;
  folder.write("s/depth.txt", "1 depth/1.png\n");
  EXPECT_TRUE(list_frames(folder / "s").ok());
  folder.write("s/rgb.txt", "1\n");
  EXPECT_THAT(list_frames(folder / "s").error().message, HasSubstr("rgb.txt:1: "));
  folder.write("s/depth.txt", "1 ../../secret.png\n");
  EXPECT_THAT(list_frames(folder / "s").error().message, HasSubstr("depth.txt:1: file name leads out of the folder"));
}

class RealData : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(data_)) GTEST_SKIP() << "no data in " << data_;
  }
  const fs::path data_ = FRANSAC_DATA_DIR;
};

TEST_F(RealData, EveryFrameLoads) {
  for (const char* name : {"tum", "mosd", "icl_nuim", "other", "tum_sequence/rgbd_dataset_freiburg1_desk_excerpt"}) {
    const auto dataset = list_frames(data_ / name);
    ASSERT_TRUE(dataset.ok()) << dataset.error().message;
    for (const FrameFiles& files : dataset->frames) {
      const auto frame = load_frame(files);
      ASSERT_TRUE(frame.ok()) << frame.error().message;
      EXPECT_TRUE(validate(frame->view()).ok());
      EXPECT_EQ(frame->labels.has_value(), dataset->truth != Truth::none);
      EXPECT_EQ(frame->objects.has_value(), dataset->name == "mosd");
      if (!files.colour) continue;
      EXPECT_TRUE(read_colour_image(*files.colour).ok()) << *files.colour;
    }
  }
}

TEST_F(RealData, TheSequenceHasNineFramesWithTheirPictures) {
  const auto dataset = list_frames(data_ / "tum_sequence/rgbd_dataset_freiburg1_desk_excerpt");
  ASSERT_TRUE(dataset.ok()) << dataset.error().message;
  ASSERT_EQ(dataset->frames.size(), 9U);
  for (const FrameFiles& files : dataset->frames) EXPECT_EQ(files.colour->stem(), files.depth.stem());
  EXPECT_TRUE(std::is_sorted(dataset->frames.begin(), dataset->frames.end(),
                             [](const auto& a, const auto& b) { return *a.timestamp_s < *b.timestamp_s; }));
}

TEST_F(RealData, TruePlanesLieUnderTheirLabels) {
  const auto frame = load_frame(list_frames(data_ / "tum/scene4")->frames[0]);
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  ASSERT_EQ(frame->true_planes.size(), 7U);
  const auto& [label, floor] = frame->true_planes[0];
  EXPECT_EQ(label, 1);
  EXPECT_GT(floor.d, 1.4);  // the camera is on the positive side, 1.45 m above the floor
  const DepthView depth = frame->view();
  double sum_of_squares = 0.0;
  double count = 0.0;
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u) {
      if (frame->labels->pixels[static_cast<std::size_t>(v * depth.width() + u)] != 1) continue;
      const double z = static_cast<double>(depth.metres(u, v));
      const Camera& camera = frame->camera;
      const double distance =
          floor.signed_distance(z * Eigen::Vector3d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0));
      sum_of_squares += distance * distance;
      ++count;
    }
  }
  EXPECT_GT(count, 50000);
  EXPECT_LT(std::sqrt(sum_of_squares / count), 0.006);  // its truth.json gives 4 mm for the core
}

}  // namespace
}  // namespace fransac::io

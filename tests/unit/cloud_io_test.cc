// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pcl/console/print.h>
#include <pcl/io/lzf.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "fransac/core/random.hpp"
#include "fransac/io/cloud_file.hpp"
#include "fransac/io/overlay.hpp"
#include "io/cloud_formats.h"
#include "io/lzf.h"
#include "unit/temporary_folder.h"

namespace fransac::io {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

struct Format {
  const char* extension;
  CloudEncoding encoding;
};
constexpr Format kFormats[] = {{".pcd", CloudEncoding::ascii},
                               {".pcd", CloudEncoding::binary},
                               {".pcd", CloudEncoding::binary_compressed},
                               {".ply", CloudEncoding::ascii},
                               {".ply", CloudEncoding::binary}};

class CloudFile : public ::testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path file(const std::string& name) const { return folder_ / name; }
  fransac::testing::TemporaryFolder folder_;
};

PointCloud random_cloud(int width, int height, const Eigen::Vector3d& origin, bool with_gaps) {
  PointCloud cloud;
  cloud.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  cloud.width = width;
  cloud.height = height;
  cloud.origin = origin;
  RandomStream random(7, 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (with_gaps && i % 5 == 3) continue;
    const auto coordinate = [&] { return static_cast<float>(20.0 * random.uniform() - 10.0); };
    const float x = coordinate();
    const float y = coordinate();
    cloud.set(i, {x, y, coordinate()});
  }
  return cloud;
}

std::vector<std::uint8_t> some_labels(std::size_t size) {
  std::vector<std::uint8_t> labels(size);
  for (std::size_t i = 0; i < size; ++i) labels[i] = i % 4 == 3 ? 255 : static_cast<std::uint8_t>(i % 4);
  return labels;
}

void expect_same_points(const PointCloud& actual, const PointCloud& expected, double tolerance) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_EQ(actual.finite(i), expected.finite(i)) << i;
    if (expected.finite(i)) {
      ASSERT_LE((actual.point(i) - expected.point(i)).cwiseAbs().maxCoeff(), tolerance) << i;
    } else {
      ASSERT_TRUE(std::isnan(actual.x()[i]) && std::isnan(actual.y()[i]) && std::isnan(actual.z()[i])) << i;
    }
  }
}

Result<PointCloud> decode(const std::string& content, const ReadLimits& limits = {}) {
  return cloud_formats::decode_cloud(std::as_bytes(std::span(content)), "cloud", limits);
}

std::string error_of(const std::string& content, const ReadLimits& limits = {}) {
  const auto cloud = decode(content, limits);
  return cloud ? "no error" : cloud.error().message;
}

std::string pcd(const std::string& data, const std::string& fields = "x y z", const std::string& size = "4 4 4",
                const std::string& type = "F F F", const std::string& count = "1 1 1", const std::string& extent = "2 1 2",
                const std::string& encoding = "ascii") {
  std::istringstream stream(extent);
  std::string width;
  std::string height;
  std::string points;
  stream >> width >> height >> points;
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS " + fields + "\nSIZE " + size + "\nTYPE " + type + "\nCOUNT " + count + "\nWIDTH " +
         width + "\nHEIGHT " + height + "\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + points + "\nDATA " + encoding + "\n" + data;
}

std::string ply(const std::string& data, const std::string& elements, const std::string& encoding = "ascii") {
  return "ply\nformat " + encoding + " 1.0\n" + elements + "end_header\n" + data;
}
const std::string kTwoVertices = "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n";

template <class T>
std::string raw(T value, bool swapped = false) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  if (swapped) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

// ---- round trips ----

TEST_F(CloudFile, EveryFormatKeepsFloatsExactly) {
  const PointCloud cloud = random_cloud(101, 1, Eigen::Vector3d::Zero(), false);
  for (const auto& [extension, encoding] : kFormats) {
    const auto path = file(std::string("cloud") + extension);
    ASSERT_TRUE(write_cloud(path, cloud, {}, encoding).ok());
    const auto back = read_cloud(path);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->origin, Eigen::Vector3d::Zero());
    EXPECT_EQ(back->width, 101);
    EXPECT_EQ(back->height, 1);
    expect_same_points(*back, cloud, 0.0);
  }
}

TEST_F(CloudFile, OrganisedCloudsKeepTheirShapeAndTheirGaps) {
  const PointCloud cloud = random_cloud(13, 7, Eigen::Vector3d::Zero(), true);
  for (const auto& [extension, encoding] : kFormats) {
    const auto path = file(std::string("cloud") + extension);
    ASSERT_TRUE(write_cloud(path, cloud, some_labels(cloud.size()), encoding).ok());
    const auto back = read_cloud(path);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->width, 13);
    EXPECT_EQ(back->height, 7);
    EXPECT_TRUE(std::isnan(back->x()[back->padded_size() - 1]));
    expect_same_points(*back, cloud, 0.0);
  }
}

TEST_F(CloudFile, UtmCoordinatesLoseNothing) {
  const PointCloud cloud = random_cloud(40, 2, {512300.0, 5403800.0, 312.0}, true);
  for (const auto& [extension, encoding] : kFormats) {
    const auto path = file(std::string("cloud") + extension);
    ASSERT_TRUE(write_cloud(path, cloud, some_labels(cloud.size()), encoding).ok());
    const auto back = read_cloud(path);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_LT((back->origin - cloud.origin).cwiseAbs().maxCoeff(), 11.0);
    expect_same_points(*back, cloud, 20.0 * std::ldexp(1.0, -24));  // Half a unit in the last place of a local float.
  }
}

TEST_F(CloudFile, OneWildPointDoesNotMoveTheOrigin) {
  std::string lines;
  for (int i = 0; i < 9; ++i) lines += "5000.25 2000.5 " + std::to_string(i) + "\n";
  const auto cloud = decode(pcd(lines + "1e12 0 0\n", "x y z", "8 8 8", "F F F", "1 1 1", "10 1 10"));
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_EQ(cloud->origin, Eigen::Vector3d(5000.0, 2001.0, 4.0));  // The sixth of ten; a half rounds up.
  EXPECT_EQ(cloud->point(4), Eigen::Vector3d(5000.25, 2000.5, 4.0));
}

TEST_F(CloudFile, NumbersThatFloatCannotHoldAreNoPoints) {
  const auto cloud = decode(pcd("1e300 0 0\n1e999 2 3\n-inf 2 3\n1 2 3\n+4 5 6\n", "x y z", "8 8 8", "F F F", "1 1 1", "5 1 5"));
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(std::isnan(cloud->x()[i]) && std::isnan(cloud->z()[i])) << i;
  EXPECT_EQ(cloud->point(3), Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(cloud->point(4), Eigen::Vector3d(4.0, 5.0, 6.0));
}

// ---- against PCL ----

TEST_F(CloudFile, PclReadsPointsColoursAndLabels) {
  const PointCloud cloud = random_cloud(9, 6, Eigen::Vector3d::Zero(), true);
  const auto labels = some_labels(cloud.size());
  for (const auto& [extension, encoding] : kFormats) {
    const auto path = file(std::string("cloud") + extension);
    ASSERT_TRUE(write_cloud(path, cloud, labels, encoding).ok());
    pcl::PointCloud<pcl::PointXYZRGBL> theirs;
    const bool is_pcd = std::string(extension) == ".pcd";
    ASSERT_EQ(is_pcd ? pcl::io::loadPCDFile(path.string(), theirs) : pcl::io::loadPLYFile(path.string(), theirs), 0);
    ASSERT_EQ(theirs.size(), cloud.size());
    EXPECT_EQ(theirs.width, 9U);
    EXPECT_EQ(theirs.height, 6U);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (cloud.finite(i)) {
        EXPECT_EQ(theirs[i].getVector3fMap(), cloud.local(i).cast<float>()) << i;
      } else {
        EXPECT_TRUE(std::isnan(theirs[i].x) && std::isnan(theirs[i].y) && std::isnan(theirs[i].z)) << i;
      }
      EXPECT_EQ(theirs[i].label, labels[i]);
      const bool on_plane = labels[i] != 0 && labels[i] != 255;
      const auto colour = on_plane ? label_colour(labels[i]) : std::array<std::uint8_t, 3>{128, 128, 128};
      EXPECT_EQ((std::array{theirs[i].r, theirs[i].g, theirs[i].b}), colour) << extension << int(encoding) << " " << i;
    }
  }
}

TEST_F(CloudFile, PclReadsObstacles) {
  const PointCloud cloud = random_cloud(9, 6, Eigen::Vector3d::Zero(), true);
  std::vector<std::uint16_t> obstacles(cloud.size());
  for (std::size_t i = 0; i < obstacles.size(); ++i) obstacles[i] = static_cast<std::uint16_t>(65535 - 1000 * i);
  for (const auto& [extension, encoding] : kFormats) {
    for (const auto& labels : {some_labels(cloud.size()), std::vector<std::uint8_t>()}) {
      const auto path = file(std::string("cloud") + extension);
      ASSERT_TRUE(write_cloud(path, cloud, labels, encoding, obstacles).ok());
      pcl::PCLPointCloud2 theirs;
      const bool is_pcd = std::string(extension) == ".pcd";
      ASSERT_EQ(is_pcd ? pcl::io::loadPCDFile(path.string(), theirs) : pcl::io::loadPLYFile(path.string(), theirs), 0);
      const auto field =
          std::find_if(theirs.fields.begin(), theirs.fields.end(), [](const auto& f) { return f.name == "obstacle"; });
      ASSERT_NE(field, theirs.fields.end());
      ASSERT_EQ(field->datatype, pcl::PCLPointField::UINT32);
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        std::uint32_t value = 0;
        std::memcpy(&value, &theirs.data[i * theirs.point_step + field->offset], sizeof value);
        EXPECT_EQ(value, obstacles[i]) << extension << int(encoding) << " " << i;
      }
    }
  }
}

TEST_F(CloudFile, PclReadsDoubles) {
  const PointCloud cloud = random_cloud(11, 1, {512300.0, 5403800.0, 312.0}, false);
  for (const auto& [extension, encoding] : kFormats) {
    const auto path = file(std::string("cloud") + extension);
    ASSERT_TRUE(write_cloud(path, cloud, {}, encoding).ok());
    pcl::PCLPointCloud2 theirs;
    const bool is_pcd = std::string(extension) == ".pcd";
    ASSERT_EQ(is_pcd ? pcl::io::loadPCDFile(path.string(), theirs) : pcl::io::loadPLYFile(path.string(), theirs), 0);
    ASSERT_EQ(theirs.fields.size(), 3U);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ASSERT_EQ(theirs.fields[axis].datatype, pcl::PCLPointField::FLOAT64);
        double value = 0.0;
        std::memcpy(&value, &theirs.data[i * theirs.point_step + theirs.fields[axis].offset], sizeof value);
        EXPECT_EQ(value, cloud.point(i)[static_cast<int>(axis)]);
      }
    }
  }
}

TEST_F(CloudFile, ReadsWhatPclWrites) {
  pcl::PointCloud<pcl::PointNormal> theirs(5, 4);
  RandomStream random(11, 0);
  for (auto& point : theirs) point.getVector3fMap().setConstant(static_cast<float>(random.uniform()));
  theirs[7].x = theirs[7].y = theirs[7].z = kNaN;
  pcl::PCLPointCloud2 blob;
  pcl::toPCLPointCloud2(theirs, blob);  // Has padding fields.
  const auto zero = Eigen::Vector4f::Zero();
  const auto identity = Eigen::Quaternionf::Identity();
  const std::string paths[] = {file("a.pcd"), file("b.pcd"), file("c.pcd"), file("a.ply"), file("b.ply")};
  ASSERT_EQ(pcl::PCDWriter().writeASCII(paths[0], blob, zero, identity, 9), 0);
  ASSERT_EQ(pcl::PCDWriter().writeBinary(paths[1], blob), 0);
  ASSERT_EQ(pcl::PCDWriter().writeBinaryCompressed(paths[2], blob), 0);
  ASSERT_EQ(pcl::PLYWriter().writeASCII(paths[3], blob, zero, identity, 9), 0);
  ASSERT_EQ(pcl::PLYWriter().writeBinary(paths[4], blob), 0);
  for (const auto& path : paths) {
    const auto cloud = read_cloud(path);
    ASSERT_TRUE(cloud.ok()) << cloud.error().message;
    EXPECT_EQ(cloud->width, 5) << path;
    EXPECT_EQ(cloud->height, 4) << path;
    ASSERT_EQ(cloud->size(), 20U);
    for (std::size_t i = 0; i < 20; ++i) {
      if (i == 7) {
        EXPECT_FALSE(cloud->finite(i));
      } else {
        EXPECT_EQ(cloud->local(i).cast<float>(), theirs[i].getVector3fMap()) << path << i;
      }
    }
  }
}

// ---- real clouds ----

TEST(RealClouds, HaveTheirCounts) {
  const std::filesystem::path folder = std::filesystem::path(FRANSAC_DATA_DIR) / "clouds";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "needs " << folder;
  struct Expected {
    const char* name;
    std::size_t size;
    bool far;
  };
  for (const auto& [name, size, far] :
       {Expected{"251370668.pcd", 69088, false}, Expected{"region_growing_tutorial.pcd", 108104, true},
        Expected{"room_scan1.pcd", 112586, false}, Expected{"room_scan2.pcd", 112624, false},
        Expected{"samp11-utm-ground.pcd", 21786, true}, Expected{"samp11-utm.pcd", 38010, true}}) {
    const auto cloud = read_cloud(folder / name);
    ASSERT_TRUE(cloud.ok()) << cloud.error().message;
    EXPECT_EQ(cloud->size(), size) << name;
    EXPECT_EQ(!cloud->origin.isZero(0.0), far) << name;
    pcl::PointCloud<pcl::PointXYZ> theirs;
    ASSERT_EQ(pcl::io::loadPCDFile((folder / name).string(), theirs), 0);
    for (std::size_t i = 0; i < size; ++i) {
      ASSERT_EQ(cloud->finite(i), theirs[i].getVector3fMap().allFinite());
      if (!cloud->finite(i)) continue;
      const double rounding =
          std::ldexp(cloud->local(i).cwiseAbs().maxCoeff(), -24);  // Of the local float; none without an origin.
      const Eigen::Vector3d difference = cloud->point(i) - theirs[i].getVector3fMap().cast<double>();
      ASSERT_LE(difference.cwiseAbs().maxCoeff(), far ? rounding : 0.0) << name << " " << i;
    }
  }
}

TEST(RealClouds, PointsAtTheOriginAreData) {
  const std::filesystem::path path = std::filesystem::path(FRANSAC_DATA_DIR) / "clouds/251370668.pcd";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "needs " << path;
  const auto cloud = read_cloud(path);
  ASSERT_TRUE(cloud.ok());
  std::size_t zeros = 0;
  for (std::size_t i = 0; i < cloud->size(); ++i) zeros += cloud->local(i).isZero(0.0) ? 1U : 0U;
  EXPECT_EQ(zeros, 5032U);
}

// ---- what the headers may hold ----

TEST(Pcd, OldVersionsAndExtraFields) {
  const auto oldest = decode("VERSION .5\nCOLUMNS x y z\nPOINTS 2\nDATA ascii\n1 2 3\n4 5 6\n");
  ASSERT_TRUE(oldest.ok()) << oldest.error().message;
  EXPECT_EQ(oldest->point(1), Eigen::Vector3d(4, 5, 6));
  const auto old = decode(
      "VERSION .6\r\nFIELDS rgb x y z\r\nSIZE 4 4 4 4\r\nTYPE F F F F\r\nWIDTH 1\r\nHEIGHT 2\r\nDATA ascii\r\n"
      "0 1 2 3\r\n\r\n0 nan 5 6\r\n");
  ASSERT_TRUE(old.ok()) << old.error().message;
  EXPECT_EQ(old->point(0), Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(std::isnan(old->z()[1]));
  EXPECT_EQ(old->height, 2);
  const auto mixed =
      decode(pcd("9 9 9 1 7 2 3\n9 9 9 4 7 5 6\n", "normal x intensity y z", "4 8 1 8 8", "F F U F F", "3 1 1 1 1"));
  ASSERT_TRUE(mixed.ok()) << mixed.error().message;
  EXPECT_EQ(mixed->point(1), Eigen::Vector3d(4, 5, 6));
}

TEST(Pcd, BinaryFieldsInAnyOrder) {
  const std::string point = raw<std::uint16_t>(7) + raw(3.0) + std::string(5, 'p') + raw(1.5F) + raw(-2.5F);
  const auto cloud = decode(pcd(point + point, "ring z _ x y", "2 8 1 4 4", "U F U F F", "1 1 5 1 1", "2 1 2", "binary"));
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_EQ(cloud->point(1), Eigen::Vector3d(1.5, -2.5, 3.0));
}

TEST(Pcd, EmptyIsACloudWithoutPoints) {
  for (const char* encoding : {"ascii", "binary", "binary_compressed"}) {
    const auto cloud = decode(pcd("", "x y z", "4 4 4", "F F F", "1 1 1", "0 1 0", encoding));
    ASSERT_TRUE(cloud.ok()) << cloud.error().message;
    EXPECT_TRUE(cloud->empty());
  }
}

TEST(Pcd, WrongHeadersAreNamed) {
  const std::string data = "1 2 3\n4 5 6\n";
  EXPECT_EQ(error_of(""), "cloud: is empty");
  EXPECT_EQ(error_of("hello\n"), "cloud: is neither a PCD nor a PLY file");
  EXPECT_EQ(error_of("VERSION 0.7\nFIELDS x y z\n"), "cloud: the PCD header has no DATA line");
  EXPECT_THAT(error_of(pcd(data, "x y w")), HasSubstr("no field 'z'"));
  EXPECT_THAT(error_of(pcd(data, "x y x")), HasSubstr("a second field 'x'"));
  EXPECT_THAT(error_of(pcd(data, "x y z", "4 4")), HasSubstr("SIZE has 2 values, expected 3"));
  EXPECT_THAT(error_of(pcd(data, "x y z", "4 4 3")), HasSubstr("field 'z': TYPE 'F' with SIZE 3"));
  EXPECT_THAT(error_of(pcd(data, "x y z", "4 4 -4")), HasSubstr("SIZE '-4'"));
  EXPECT_THAT(error_of(pcd(data, "x y z", "4 4 4", "F F FF")), HasSubstr("field 'z': TYPE"));
  EXPECT_THAT(error_of(pcd(data, "x y z", "4 4 4", "F F F", "1 1 2")), HasSubstr("field 'z' is not one number"));
  EXPECT_THAT(error_of(pcd(data, "x y z", "4 4 4", "F F F", "1 1 0")), HasSubstr("field 'z': COUNT is 0"));
  EXPECT_THAT(error_of(pcd(data, "x y z i", "4 4 4 8", "F F F F", "1 1 1 2147483647")), HasSubstr("2147483647 bytes"));
  EXPECT_THAT(error_of(pcd(data, "x y z", "4 4 4", "F F F", "1 1 1", "2 2 2")), HasSubstr("WIDTH 2 x HEIGHT 2 is not POINTS 2"));
  EXPECT_THAT(error_of(pcd(data, "x y z", "4 4 4", "F F F", "1 1 1", "-2 1 2")), HasSubstr("WIDTH '-2'"));
  EXPECT_THAT(error_of(pcd(data, "x y z", "4 4 4", "F F F", "1 1 1", "2147483647 2147483647 1")), HasSubstr("2147483647 points"));
  EXPECT_THAT(error_of(pcd(data, "x y z", "4 4 4", "F F F", "1 1 1", "99999999999 1 2")), HasSubstr("WIDTH '99999999999'"));
  EXPECT_THAT(error_of(pcd(data, "x y z", "4 4 4", "F F F", "1 1 1", "2 1 2", "zipped")), HasSubstr("DATA is not"));
  EXPECT_THAT(error_of("VERSION 0.7\nVERSION 0.7\n"), HasSubstr("line 2: a second VERSION"));
  EXPECT_THAT(error_of("VERSION 9\n" + pcd(data).substr(pcd(data).find("FIELDS"))), HasSubstr("VERSION"));
  EXPECT_THAT(error_of("VERSION 0.7\nNONSENSE 1\n"), HasSubstr("line 2: no PCD header line starts with 'NONSENSE'"));
}

TEST(Pcd, TheViewpointIsWhereTheSensorWas) {
  const std::string data = "1 2 3\n4 5 6\n";
  const auto with = [&](const std::string& viewpoint) {
    const std::string known = "VIEWPOINT 0 0 0 1 0 0 0";
    std::string text = pcd(data);
    return text.replace(text.find(known), known.size(), viewpoint);
  };
  EXPECT_EQ(decode(with("VIEWPOINT 1.5 -2 456789.25 0 1 0 0"))->sensor_position, Eigen::Vector3d(1.5, -2.0, 456789.25));
  EXPECT_EQ(decode(with("VIEWPOINT 1.5 -2 3 0 1 0 0"))->point(0), Eigen::Vector3d(1, 2, 3));  // not turned, not moved
  EXPECT_FALSE(decode(with("VIEWPOINT 0 0 0 1 0 0 0"))->sensor_position.has_value());  // what PCL writes without knowing it
  EXPECT_FALSE(decode(with("# none"))->sensor_position.has_value());
  EXPECT_THAT(error_of(with("VIEWPOINT 0 0 0")), HasSubstr("VIEWPOINT has 3 values, expected 7"));
  EXPECT_THAT(error_of(with("VIEWPOINT 0 0 x 1 0 0 0")), HasSubstr("VIEWPOINT 'x' is not a finite number"));
  EXPECT_THAT(error_of(with("VIEWPOINT 0 0 0 nan 0 0 0")), HasSubstr("VIEWPOINT 'nan' is not a finite number"));
  EXPECT_EQ(decode(with("VIEWPOINT 0 -1e30 0 1 0 0 0"))->sensor_position, Eigen::Vector3d(0.0, -1e30, 0.0));
  EXPECT_THAT(error_of(with("VIEWPOINT 0 -1.1e30 0 1 0 0 0")), HasSubstr("VIEWPOINT: must be finite, with no coordinate beyond"));
}

TEST(Pcd, WrongBodiesAreNamed) {
  EXPECT_THAT(error_of(pcd("1 2 3\n4 five 6\n")), HasSubstr("line 13: y is 'five', not a number"));
  EXPECT_THAT(error_of(pcd("1 2 3\n4 5\n   \n")), HasSubstr("line 13: 2 values, expected 3"));
  EXPECT_THAT(error_of(pcd("1 2 3\n4 5 6 7\n")), HasSubstr("line 13: 4 values, expected 3"));
  EXPECT_THAT(error_of(pcd("1 2 3\n4 5 6\n7 8 9\n")), HasSubstr("line 14: more than the 2 points"));
  EXPECT_THAT(error_of(pcd("100.125 2 3\n")), HasSubstr("has 1 points, the header says 2"));
  const auto huge = [](const std::string& encoding) {
    return error_of(pcd("1 2 3\n4 5 6\n", "x y z", "4 4 4", "F F F", "1 1 1", "2000000000 1 2000000000", encoding));
  };
  EXPECT_THAT(huge("ascii"), HasSubstr("2000000000 points need"));
  EXPECT_THAT(huge("binary"), HasSubstr("2000000000 points need 24000000000 bytes after the header, the file has 12"));
  EXPECT_THAT(huge("binary_compressed"), HasSubstr("2000000000 points need 24000000000"));
}

TEST(Pcd, WrongCompressedSizesAreNamed) {
  const auto compressed = [](const std::string& data) {
    return error_of(pcd(data, "x y z", "4 4 4", "F F F", "1 1 1", "2 1 2", "binary_compressed"));
  };
  EXPECT_THAT(compressed("1234567"), HasSubstr("sizes are missing"));
  EXPECT_THAT(compressed(raw(9U) + raw(24U) + "12345678"), HasSubstr("has 9 bytes, the file only 8"));
  EXPECT_THAT(compressed(raw(8U) + raw(25U) + "12345678"), HasSubstr("expands to 25 bytes, 2 points need 24"));
  EXPECT_THAT(compressed(raw(0U) + raw(24U)), HasSubstr("0 compressed bytes cannot hold 24"));
  EXPECT_THAT(compressed(raw(8U) + raw(24U) + std::string(8, '\xff')), HasSubstr("the compressed data is damaged"));
  EXPECT_THAT(compressed(raw(8U) + raw(24U) + std::string(8, '\x1f')), HasSubstr("the compressed data is damaged"));
}

// ---- PLY ----

TEST(Ply, FacesCommentsAndForeignElementsAreSkipped) {
  const std::string elements =
      "comment by hand\r\nobj_info made of\r\nelement sensor 1\r\nproperty list ushort double w\r\nproperty char mode\r\n"
      "element vertex 2\r\nproperty uchar red\r\nproperty double x\r\nproperty list uchar int seen_by\r\nproperty float y\r\n"
      "property uchar blue\r\nproperty float z\r\nelement face 2\r\nproperty list int int vertex_indices\r\nproperty float "
      "area\r\n";
  const auto text = decode("ply\r\nformat ascii 1.0\r\n" + elements +
                           "end_header\r\n2 0.5 0.5 1\r\n9 1 2 7 7 2 9 3\r\n9 4 0 5 9 6\r\n"
                           "3 0 1 0 0.5\r\n0 0\r\n");
  ASSERT_TRUE(text.ok()) << text.error().message;
  ASSERT_EQ(text->size(), 2U);
  EXPECT_EQ(text->point(0), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(text->point(1), Eigen::Vector3d(4, 5, 6));
  for (const bool big : {false, true}) {
    const auto list = [&](std::int32_t a) { return raw(a, big); };
    const std::string body = raw<std::uint16_t>(2, big) + raw(0.5, big) + raw(0.5, big) + "m" +                        //
                             "r" + raw(1.0, big) + "\2" + list(7) + list(7) + raw(2.0F, big) + "b" + raw(3.0F, big) +  //
                             "r" + raw(4.0, big) + std::string(1, '\0') + raw(5.0F, big) + "b" + raw(6.0F, big) +      //
                             list(3) + list(0) + list(1) + list(0) + raw(0.5F, big) + list(0) + raw(0.5F, big);
    const std::string format = big ? "binary_big_endian" : "binary_little_endian";
    const std::string file = "ply\r\nformat " + format + " 1.0\r\n" + elements + "end_header\r\n" + body;
    const auto binary = decode(file);
    ASSERT_TRUE(binary.ok()) << binary.error().message;
    EXPECT_EQ(binary->point(0), Eigen::Vector3d(1, 2, 3));
    EXPECT_EQ(binary->point(1), Eigen::Vector3d(4, 5, 6));
    for (std::size_t length = 0; length < file.size(); ++length) EXPECT_FALSE(decode(file.substr(0, length)).ok()) << length;
    EXPECT_FALSE(decode(file + "x").ok());
  }
}

TEST(Ply, WrongHeadersAreNamed) {
  const std::string data = "1 2 3\n4 5 6\n";
  EXPECT_THAT(error_of("ply\n"), HasSubstr("no end_header"));
  EXPECT_THAT(error_of("ply\n" + kTwoVertices + "end_header\n" + data), HasSubstr("no format line"));
  EXPECT_THAT(error_of(ply(data, kTwoVertices, "ebcdic")), HasSubstr("line 2: 'ebcdic' is no encoding"));
  EXPECT_THAT(error_of(ply(data, "format ascii 1.0\n" + kTwoVertices)), HasSubstr("line 3: a second format"));
  EXPECT_THAT(error_of(ply(data, "")), HasSubstr("no element 'vertex'"));
  EXPECT_THAT(error_of(ply(data, kTwoVertices + kTwoVertices)), HasSubstr("line 7: a second element 'vertex'"));
  EXPECT_THAT(error_of(ply(data, "element vertex 2\nproperty float x\nproperty float y\n")), HasSubstr("no property 'z'"));
  EXPECT_THAT(error_of(ply(data, kTwoVertices + "property float x\n")), HasSubstr("a second property 'x'"));
  EXPECT_THAT(error_of(ply(data, "element vertex 2\nproperty list int float x\nproperty float y\nproperty float z\n")),
              HasSubstr("no property 'x' that is a number"));
  EXPECT_THAT(error_of(ply(data, kTwoVertices + "property list float int w\n")), HasSubstr("'float' cannot count"));
  EXPECT_THAT(error_of(ply(data, kTwoVertices + "property half w\n")), HasSubstr("'half' is no type"));
  EXPECT_THAT(error_of(ply(data, "property float x\n")), HasSubstr("before the first element"));
  EXPECT_THAT(error_of(ply(data, "element vertex -2\n")), HasSubstr("line 3: expected 'element NAME COUNT'"));
  EXPECT_THAT(error_of(ply(data, "wrong\n")), HasSubstr("'wrong'"));
}

/// Of a file of two points.
void expect_points(const std::string& file) {
  const auto cloud = decode(file);
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  ASSERT_EQ(cloud->size(), 2U);
  EXPECT_EQ(cloud->point(0), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(cloud->point(1), Eigen::Vector3d(4, 5, 6));
}

TEST(Ply, CoordinatesOfAnyNumberTypeAndCaseAreRead) {
  const std::string data = "1 2 3\n4 5 6\n";
  expect_points(ply(data, "element vertex 2\nproperty short x\nproperty uint y\nproperty double z\n"));
  expect_points(ply(data, "element vertex 2\nproperty float X\nproperty float Y\nproperty float Z\n"));
  expect_points("\xef\xbb\xbf" + ply(data, kTwoVertices));
  std::string shorts;
  for (std::int16_t value = 1; value <= 6; ++value) shorts += raw(value);
  const std::string elements = "element vertex 2\nproperty short x\nproperty short y\nproperty short z\n";
  for (const char* const end : {"", "\n", "\r\n"}) expect_points(ply(shorts + end, elements, "binary_little_endian"));
  EXPECT_THAT(error_of(ply(shorts + "\n\n", elements, "binary_little_endian")), HasSubstr("more data than its header says"));
  // Both cases: the first named, as other readers take it.
  expect_points(ply("1 2 3 9\n4 5 6 9\n", kTwoVertices + "property float X\n"));
}

TEST(Pcd, CoordinatesOfAnyNumberTypeAndCaseAreRead) {
  expect_points(pcd("1 2 3\n4 5 6\n", "x y z", "2 4 8", "I U F"));
  expect_points(pcd("1 2 3\n4 5 6\n", "X Y Z"));
  expect_points("\xef\xbb\xbf" + pcd("1 2 3\n4 5 6\n"));
  const auto binary = [&]<class T>(T /*type*/, const char* size, const char* type) {
    std::string data;
    for (int value = 1; value <= 6; ++value) data += raw(static_cast<T>(value));
    const std::string sizes = std::string(size) + " " + size + " " + size;
    const std::string types = std::string(type) + " " + type + " " + type;
    expect_points(pcd(data + "\n", "x y z", sizes, types, "1 1 1", "2 1 2", "binary"));
  };
  binary(std::int8_t{}, "1", "I");
  binary(std::uint8_t{}, "1", "U");
  binary(std::int16_t{}, "2", "I");
  binary(std::uint16_t{}, "2", "U");
  binary(std::int32_t{}, "4", "I");
  binary(std::uint32_t{}, "4", "U");
  binary(std::int64_t{}, "8", "I");
  binary(std::uint64_t{}, "8", "U");
}

TEST(Xyz, LinesOfNumbersAreRead) {
  const auto read = [](const std::string& content) {
    return cloud_formats::decode_cloud(std::as_bytes(std::span(content)), "cloud.XYZ");
  };
  for (const char* const content : {"1 2 3\n4 5 6\n", "1,2,3\r\n4,5,6", "2\n1 2 3 0.5 255 0 0\n4 5 6 0.5 255 0 0\n",
                                    "X;Y;Z\n1;2;3\n4;5;6\n", "# a scanner's\n\n1\t2\t3 // first\n4\t5\t6\n",
                                    "\xef\xbb\xbf"
                                    "1 2 3\n4 5 6\n"}) {
    const auto cloud = read(content);
    ASSERT_TRUE(cloud.ok()) << cloud.error().message << content;
    ASSERT_EQ(cloud->size(), 2U) << content;
    EXPECT_EQ(cloud->point(0), Eigen::Vector3d(1, 2, 3)) << content;
    EXPECT_EQ(cloud->point(1), Eigen::Vector3d(4, 5, 6)) << content;
    EXPECT_EQ(cloud->height, 1);
  }
  EXPECT_EQ(read("1 2 3\n4 5\n").error().message, "cloud.XYZ: line 2: fewer than three numbers");
  EXPECT_EQ(read("1 2 3\n4 five 6\n").error().message, "cloud.XYZ: line 2: 'five' is not a number");
  EXPECT_EQ(read("1 2\n").error().message, "cloud.XYZ: line 1: fewer than three numbers");
  EXPECT_EQ(read("x y z\n").error().message, "cloud.XYZ: holds no line \"x y z\"");
  // What the content says counts more than the name.
  EXPECT_TRUE(read(pcd("1 2 3\n4 5 6\n")).ok());
  EXPECT_TRUE(read(ply("1 2 3\n4 5 6\n", kTwoVertices)).ok());
}

TEST_F(CloudFile, ThePositionOfTheSensorIsKeptAndHasTheUnitOfTheCoordinates) {
  PointCloud cloud = random_cloud(5, 1, Eigen::Vector3d::Zero(), false);
  cloud.sensor_position = Eigen::Vector3d(1.0, -2.0, 0.5);
  for (const auto encoding : {CloudEncoding::ascii, CloudEncoding::binary, CloudEncoding::binary_compressed}) {
    const auto path = file("seen.pcd");
    ASSERT_TRUE(write_cloud(path, cloud, {}, encoding).ok());
    EXPECT_EQ(read_cloud(path)->sensor_position, cloud.sensor_position);
    EXPECT_EQ(read_cloud(path, 0.5)->sensor_position, Eigen::Vector3d(0.5, -1.0, 0.25));
  }
  cloud.sensor_position->y() = std::nan("");  // no reader takes it
  const Status status = write_cloud(file("seen.pcd"), cloud, {}, CloudEncoding::ascii);
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().message, HasSubstr("seen.pcd: sensor position: must be finite"));
}

TEST_F(CloudFile, UnitIsThatOfTheCoordinates) {
  const auto path = file("millimetres.xyz");
  std::ofstream(path) << "1500 -250 4000\n2500.5 0 3000\n";
  const auto cloud = read_cloud(path, 0.001);
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_EQ(cloud->origin, Eigen::Vector3d::Zero());  // 4000 mm are near
  EXPECT_TRUE(cloud->point(0).isApprox(Eigen::Vector3d(1.5, -0.25, 4.0), 1e-6));
  EXPECT_TRUE(cloud->point(1).isApprox(Eigen::Vector3d(2.5005, 0.0, 3.0), 1e-6));
  for (const double wrong : {0.0, -1.0, std::nan("")}) {
    const auto refused = read_cloud(path, wrong);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::invalid_argument);
  }
}

TEST(Ply, WrongBodiesAreNamed) {
  EXPECT_THAT(error_of(ply("1 2 3\n4 five 6\n", kTwoVertices)), HasSubstr("vertex 1: property 'y' cannot be read"));
  EXPECT_THAT(error_of(ply("1.25 2 3\n4\n", kTwoVertices)), HasSubstr("vertex 1: property 'y' cannot be read"));
  EXPECT_THAT(error_of(ply("1 2 3\n4 5 6\n7\n", kTwoVertices)), HasSubstr("more data than its header says"));
  EXPECT_THAT(error_of(ply("1 2 3", "element vertex 2000000000\nproperty float x\nproperty float y\nproperty float z\n")),
              HasSubstr("too short for 2000000000 of element 'vertex'"));
  const std::string face = "element face 1\nproperty list int int vertex_indices\n";
  for (const char* count : {"-1", "1.5", "nan", "2000000000", "two"}) {
    EXPECT_THAT(error_of(ply("1 2 3\n4 5 6\n" + std::string(count) + " 0 1\n", kTwoVertices + face)),
                HasSubstr("face 0: property 'vertex_indices' cannot be read"))
        << count;
  }
}

TEST(CloudLimits, AreOnPointsAndOnWhatIsCompressed) {
  const std::string refused = "cloud: 2 points: more than the limit of 1 (--max-size)";
  EXPECT_TRUE(decode(ply("1 2 3\n4 5 6\n", kTwoVertices), {2}).ok());
  EXPECT_EQ(error_of(ply("1 2 3\n4 5 6\n", kTwoVertices), {1}), refused);
  EXPECT_TRUE(decode(pcd("1 2 3\n4 5 6\n"), {2}).ok());
  EXPECT_EQ(error_of(pcd("1 2 3\n4 5 6\n"), {1}), refused);
  EXPECT_EQ(error_of(pcd(std::string(24, '\0'), "x y z", "4 4 4", "F F F", "1 1 1", "2 1 2", "binary"), {1}), refused);
  // One point of three numbers and 250 more.
  const std::string bomb = pcd(raw(100U) + raw(1012U) + std::string(100, '\0'), "x y z w", "4 4 4 4", "F F F F", "1 1 1 250",
                               "1 1 1", "binary_compressed");
  EXPECT_EQ(error_of(bomb, {10}), "cloud: the compressed data expands to 1012 bytes: more than the limit of 80 (--max-size)");
}

TEST(Ply, AHeaderTakesTimeInProportionToItsSize) {
  const auto seconds_of = [](int count, const std::string& what) {
    std::string header = kTwoVertices;
    for (int i = 0; i < count; ++i) header += what + std::to_string(i) + (what.starts_with("element") ? " 0\n" : "\n");
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(error_of(ply("", header)).substr(0, 7), "cloud: ");
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  for (const char* const what : {"property uchar p", "element e"}) {
    const double few = seconds_of(2000, what);
    EXPECT_LT(seconds_of(100000, what), 500.0 * std::max(few, 1e-3)) << what;  // 2500 times with the square
  }
}

/// Bytes of some length, out of an alphabet of some size, with some of them repeated from before: all that LZF tells apart.
std::vector<std::uint8_t> some_bytes(RandomStream& random) {
  const std::uint32_t letters = 1 + random.below(random.below(2) == 0 ? 3 : 256);
  std::vector<std::uint8_t> bytes(random.below(20000));
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(random.below(letters));
  for (int repeats = 0; repeats < 20 && bytes.size() > 1; ++repeats) {
    const std::size_t from = random.below(static_cast<std::uint32_t>(bytes.size()));
    const std::size_t to = random.below(static_cast<std::uint32_t>(bytes.size()));
    const std::size_t most = bytes.size() - std::max(from, to);
    std::copy_n(std::vector(bytes.begin() + static_cast<std::ptrdiff_t>(from), bytes.end()).begin(),
                random.below(static_cast<std::uint32_t>(std::min<std::size_t>(most, 600))),
                bytes.begin() + static_cast<std::ptrdiff_t>(to));
  }
  return bytes;
}

TEST(Lzf, WhatOneWritesTheOtherReads) {
  RandomStream random(3, 0);
  for (int round = 0; round < 200; ++round) {
    const std::vector<std::uint8_t> plain = some_bytes(random);
    const std::string ours = compress_lzf(plain);
    EXPECT_LE(ours.size(), plain.size() + plain.size() / 32 + 1);
    std::vector<std::uint8_t> back(plain.size());
    const std::span ours_bytes(reinterpret_cast<const std::uint8_t*>(ours.data()), ours.size());
    ASSERT_TRUE(expand_lzf(ours_bytes, back)) << round;
    ASSERT_EQ(back, plain) << round;
    if (plain.empty()) continue;
    std::fill(back.begin(), back.end(), std::uint8_t{0});
    ASSERT_EQ(
        pcl::lzfDecompress(ours.data(), static_cast<unsigned>(ours.size()), back.data(), static_cast<unsigned>(back.size())),
        plain.size());
    ASSERT_EQ(back, plain) << round;

    std::vector<std::uint8_t> theirs(plain.size() * 2 + 100);
    const unsigned size =
        pcl::lzfCompress(plain.data(), static_cast<unsigned>(plain.size()), theirs.data(), static_cast<unsigned>(theirs.size()));
    if (size == 0) continue;  // what is too short for it
    std::fill(back.begin(), back.end(), std::uint8_t{0});
    ASSERT_TRUE(expand_lzf(std::span(theirs).first(size), back)) << round;
    ASSERT_EQ(back, plain) << round;
    EXPECT_LE(ours.size(), 1.1 * size + 16) << round;
  }
}

TEST(Lzf, DamagedBytesAreRefused) {
  const auto expands = [](std::initializer_list<std::uint8_t> compressed, std::size_t size) {
    std::vector<std::uint8_t> plain(size);
    return expand_lzf(std::span(compressed.begin(), compressed.size()), plain);
  };
  EXPECT_TRUE(expands({2, 'a', 'b', 'c'}, 3));
  EXPECT_FALSE(expands({2, 'a', 'b', 'c'}, 4));
  EXPECT_FALSE(expands({2, 'a', 'b', 'c'}, 2));
  EXPECT_FALSE(expands({2, 'a', 'b'}, 3));
  EXPECT_TRUE(expands({0, 'a', 0x20, 0}, 4));         // one byte, and three more like it
  EXPECT_FALSE(expands({0, 'a', 0x20, 1}, 4));        // from before the beginning
  EXPECT_FALSE(expands({0, 'a', 0x20}, 4));           // the distance is missing
  EXPECT_TRUE(expands({0, 'a', 0xe0, 255, 0}, 265));  // the longest
  EXPECT_FALSE(expands({0, 'a', 0xe0}, 265));
  EXPECT_FALSE(expands({0, 'a', 0xe0, 255}, 265));
  EXPECT_FALSE(expands({0, 'a', 0xe0, 255, 0}, 264));
}

TEST(Ply, ForeignExtentsMustFit) {
  for (const char* extent : {"obj_info num_cols 3\nobj_info num_rows 1\n", "obj_info num_cols -1\nobj_info num_rows -2\n"}) {
    const auto cloud = decode(ply("1 2 3\n4 5 6\n", extent + kTwoVertices));
    ASSERT_TRUE(cloud.ok()) << cloud.error().message;
    EXPECT_EQ(cloud->width, 2);
    EXPECT_EQ(cloud->height, 1);
  }
  const auto camera =
      decode(ply("1 2 3\n4 5 6\n1 2\n", kTwoVertices + "element camera 1\nproperty int viewportx\nproperty int viewporty\n"));
  ASSERT_TRUE(camera.ok()) << camera.error().message;
  EXPECT_EQ(camera->height, 2);
}

// ---- damaged files, refused writes ----

TEST_F(CloudFile, EveryTruncationIsAnErrorAndSilent) {
  pcl::console::setVerbosityLevel(pcl::console::L_DEBUG);
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  for (const auto& [extension, encoding] : kFormats) {
    const PointCloud cloud = random_cloud(4, 3, {5000.0, 0.0, 0.0}, false);
    const auto path = file(std::string("cloud") + extension);
    ASSERT_TRUE(write_cloud(path, cloud, some_labels(12), encoding).ok());
    const std::string content = fransac::testing::read_text(path);
    // An ascii number cut short is a number; the last one may lose its line end.
    const std::size_t shortest = content.size() - (encoding == CloudEncoding::ascii ? 3 : 0);
    for (std::size_t length = 0; length < shortest; ++length) {
      const auto cut = decode(content.substr(0, length));
      EXPECT_TRUE(!cut || cut->size() == 12) << extension << int(encoding) << " " << length;
      EXPECT_TRUE(!cut || encoding == CloudEncoding::ascii) << extension << length;
    }
    EXPECT_TRUE(decode(content).ok());
  }
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(pcl::console::getVerbosityLevel(), pcl::console::L_DEBUG);
  pcl::console::setVerbosityLevel(pcl::console::L_INFO);
}

TEST_F(CloudFile, DamagedBytesNeverCrash) {
  RandomStream random(3, 1);
  for (const auto& [extension, encoding] : kFormats) {
    const auto path = file(std::string("cloud") + extension);
    ASSERT_TRUE(write_cloud(path, random_cloud(8, 8, Eigen::Vector3d::Zero(), true), some_labels(64), encoding).ok());
    const std::string content = fransac::testing::read_text(path);
    for (int round = 0; round < 500; ++round) {
      std::string damaged = content;
      for (int i = 0; i < 3; ++i) {
        damaged[random.below(static_cast<std::uint32_t>(damaged.size()))] = static_cast<char>(random.below(256));
      }
      const auto cloud = decode(damaged);
      if (cloud) {
        EXPECT_LE(cloud->size(), damaged.size());
        EXPECT_EQ(static_cast<std::size_t>(cloud->width) * static_cast<std::size_t>(cloud->height), cloud->size());
      }
    }
  }
}

TEST_F(CloudFile, MissingFilesAreIoErrors) {
  const auto cloud = read_cloud(file("nothing.pcd"));
  ASSERT_FALSE(cloud.ok());
  EXPECT_EQ(cloud.error().code, ErrorCode::io);
  EXPECT_THAT(cloud.error().message, HasSubstr("nothing.pcd"));
}

TEST_F(CloudFile, RefusedWritesLeaveNothing) {
  const PointCloud cloud = random_cloud(3, 1, Eigen::Vector3d::Zero(), false);
  const auto refused = [&](const char* name, const PointCloud& points, std::size_t labels, CloudEncoding encoding,
                           ErrorCode code) {
    const auto status = write_cloud(file(name), points, some_labels(labels), encoding);
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().code, code);
    EXPECT_THAT(status.error().message, HasSubstr(name));
  };
  refused("cloud.txt", cloud, 3, CloudEncoding::binary, ErrorCode::invalid_argument);
  refused("cloud", cloud, 3, CloudEncoding::binary, ErrorCode::invalid_argument);
  refused("cloud.ply", cloud, 3, CloudEncoding::binary_compressed, ErrorCode::invalid_argument);
  refused("cloud.pcd", cloud, 2, CloudEncoding::binary, ErrorCode::invalid_argument);
  refused("cloud.pcd", PointCloud(), 0, CloudEncoding::binary, ErrorCode::no_data);
  refused("no/such/folder.pcd", cloud, 3, CloudEncoding::binary, ErrorCode::io);
  const std::uint16_t two_ids[2] = {};
  EXPECT_EQ(write_cloud(file("cloud.pcd"), cloud, {}, CloudEncoding::binary, two_ids).error().code, ErrorCode::invalid_argument);
  EXPECT_THAT(folder_.names(), ::testing::IsEmpty());
  EXPECT_TRUE(write_cloud(file("UPPER.PCD"), cloud, {}, CloudEncoding::binary).ok());
}

}  // namespace
}  // namespace fransac::io

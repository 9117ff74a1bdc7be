// SPDX-License-Identifier: Apache-2.0
// Guards the accuracy of every method on real frames with truth: accuracy.csv beside this file holds the means over each
// dataset's scenes, and a change of any of them fails here. When a change is meant, write the table anew, look at the
// difference and commit it:
//   FRANSAC_UPDATE_ACCURACY=1 build/release/tests/regression/accuracy_test
//
// Precision, recall and F1 are of plane 1 against truth label 1; best_f1 is of the plane that overlaps it most, which is the
// same while one plane is asked for. Defaults throughout, seed 0.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "fransac/eval/metrics.hpp"
#include "fransac/io/dataset.hpp"
#include "fransac/planes/segment.hpp"
#include "support.hpp"

namespace fransac {
namespace {

// Vector registers of other widths add up in another order and fused multiply-adds round once: a point at the threshold
// then changes sides, and now and then another hypothesis wins by a hair.
constexpr double kTolerance = 0.0005;

constexpr std::string_view kDatasets[] = {"tum", "mosd", "icl_nuim"};
constexpr std::string_view kHeader = "dataset,method,precision,recall,f1,best_f1";

struct Accuracy {
  double precision = 0.0;
  double recall = 0.0;
  double f1 = 0.0;
  double best_f1 = 0.0;
};

Accuracy mean_accuracy(const std::vector<io::Frame>& frames, Method method) {
  SegmentOptions options;
  options.method = method;
  options.threads = 0;
  Workspace workspace;
  Segmentation s;
  Accuracy sum;
  for (const io::Frame& frame : frames) {
    const Status status = segment(frame.view(), frame.camera, options, workspace, s);
    EXPECT_TRUE(status) << frame.name << ": " << (status ? "" : status.error().message);
    const auto dominant = eval::dominant_plane(frame.labels->pixels, s.labels);
    const auto best = eval::best_overlap(frame.labels->pixels, s.labels);
    if (!dominant || !best) {
      ADD_FAILURE() << frame.name;
      continue;
    }
    sum.precision += dominant->precision();
    sum.recall += dominant->recall();
    sum.f1 += dominant->f1();
    sum.best_f1 += best->detection.f1();
  }
  const auto n = static_cast<double>(frames.size());
  return {sum.precision / n, sum.recall / n, sum.f1 / n, sum.best_f1 / n};
}

std::vector<io::Frame> load_dataset(std::string_view name) {
  std::vector<io::Frame> frames;
  const auto dataset = io::list_frames(std::filesystem::path(FRANSAC_DATA_DIR) / name);
  if (!dataset) return frames;
  for (const io::FrameFiles& files : dataset->frames) {
    auto frame = io::load_frame(files);
    EXPECT_TRUE(frame) << files.name;
    if (frame && frame->labels) frames.push_back(*std::move(frame));
  }
  return frames;
}

/// Rows of the table by "dataset,method".
std::map<std::string, Accuracy> read_table() {
  std::map<std::string, Accuracy> table;
  std::ifstream file(FRANSAC_ACCURACY_CSV);
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line, kHeader);
  while (std::getline(file, line)) {
    const std::size_t key_end = line.find(',', line.find(',') + 1);
    std::string numbers = line.substr(key_end + 1);
    std::replace(numbers.begin(), numbers.end(), ',', ' ');
    Accuracy& row = table[line.substr(0, key_end)];
    std::istringstream(numbers) >> row.precision >> row.recall >> row.f1 >> row.best_f1;
  }
  return table;
}

void write_table(const std::map<std::string, Accuracy>& table) {
  std::ofstream file(FRANSAC_ACCURACY_CSV);
  file << kHeader << '\n' << std::fixed << std::setprecision(5);
  for (const std::string_view dataset : kDatasets) {
    for (const Method method : testing::kMethods) {
      const std::string key = std::string(dataset) + ',' + std::string(enum_name(method));
      const Accuracy& row = table.at(key);
      file << key << ',' << row.precision << ',' << row.recall << ',' << row.f1 << ',' << row.best_f1 << '\n';
    }
  }
  ASSERT_TRUE(file) << FRANSAC_ACCURACY_CSV;
}

TEST(Accuracy, IsThatOfTheTable) {
  std::map<std::string, Accuracy> measured;
  for (const std::string_view dataset : kDatasets) {
    const std::vector<io::Frame> frames = load_dataset(dataset);
    if (frames.empty()) GTEST_SKIP() << "no frames in " FRANSAC_DATA_DIR "/" << dataset;
    for (const Method method : testing::kMethods) {
      measured[std::string(dataset) + ',' + std::string(enum_name(method))] = mean_accuracy(frames, method);
    }
  }
  if (std::getenv("FRANSAC_UPDATE_ACCURACY") != nullptr) write_table(measured);

  const std::map<std::string, Accuracy> table = read_table();
  EXPECT_EQ(table.size(), measured.size());
  for (const auto& [key, now] : measured) {
    ASSERT_TRUE(table.count(key) == 1) << key;
    const Accuracy& before = table.at(key);
    EXPECT_NEAR(now.precision, before.precision, kTolerance) << key;
    EXPECT_NEAR(now.recall, before.recall, kTolerance) << key;
    EXPECT_NEAR(now.f1, before.f1, kTolerance) << key;
    EXPECT_NEAR(now.best_f1, before.best_f1, kTolerance) << key;
  }
  // Table-top scenes with one clear plane: these methods must find it whatever else changes.
  for (const char* const method : {"ransac", "voxel-ransac", "fransac"}) {
    EXPECT_GE(measured.at("mosd," + std::string(method)).f1, 0.99) << method;
  }
}

}  // namespace
}  // namespace fransac

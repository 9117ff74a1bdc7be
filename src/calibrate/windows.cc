// SPDX-License-Identifier: Apache-2.0
#include "calibrate/windows.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <optional>

#include "core/index.hpp"

namespace fransac::calibration {
namespace {

constexpr int kWindowsInRow = 80;
constexpr int kMinSide_px = 4;
constexpr double kMinCovered = 0.9;  // of a window: borders of planes are not theirs alone

/// The window at a place if it lies on one plane.
std::optional<Window> measure(const DepthView& depth, const Segmentation& found, int side, int row, int column,
                              std::uint8_t label) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double squares = 0.0;
  const int u0 = column * side;
  const int v0 = row * side;
  // About the first pixel, so that digits are left for the noise.
  double first = 0.0;
  for (int v = v0; v < v0 + side; ++v) {
    for (int u = u0; u < u0 + side; ++u) {
      if (found.labels[at(v) * at(found.width) + at(u)] != label) continue;
      const auto z = static_cast<double>(depth.metres(u, v));
      if (!(z > 0.0)) continue;
      if (first == 0.0) first = 1.0 / z;
      const double q = 1.0 / z - first;
      const Eigen::Vector3d a(1.0, u - u0, v - v0);
      normal += a * a.transpose();
      right += q * a;
      squares += q * q;
    }
  }
  const double count = normal(0, 0);
  if (count < kMinCovered * side * side) return std::nullopt;
  const Eigen::Vector3d fit = normal.ldlt().solve(right);
  Window window;
  window.x = 2.0 * (u0 + normal(0, 1) / count + 0.5) / found.width - 1.0;
  window.y = 2.0 * (v0 + normal(0, 2) / count + 0.5) / found.height - 1.0;
  window.q = first + right[0] / count;
  window.variance = std::max(0.0, squares - fit.dot(right)) / (count - 3.0);
  window.count = static_cast<int>(count);
  window.row = row;
  window.column = column;
  return window;
}

}  // namespace

int window_side(int width) { return std::max(kMinSide_px, (width + kWindowsInRow / 2) / kWindowsInRow); }

void collect_windows(const DepthView& depth, const Segmentation& found, std::size_t frame, double min_share,
                     std::vector<PlaneWindows>& planes) {
  const int side = window_side(found.width);
  const int rows = found.height / side;
  const int columns = found.width / side;
  const std::size_t first = planes.size();
  PlaneWindows empty;
  empty.frame = frame;
  empty.rows = rows;
  empty.columns = columns;
  empty.at.assign(at(rows) * at(columns), -1);
  planes.resize(first + found.planes.size(), empty);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      // A window that is covered has the label in its middle or, seldom, a hole there.
      const std::uint8_t label = found.labels[at(row * side + side / 2) * at(found.width) + at(column * side + side / 2)];
      if (label == kLabelNoDepth || label == kLabelNoPlane) continue;
      const std::optional<Window> window = measure(depth, found, side, row, column, label);
      if (!window) continue;
      PlaneWindows& plane = planes[first + at(label - kLabelFirst)];
      plane.at[at(row) * at(columns) + at(column)] = static_cast<std::int32_t>(plane.windows.size());
      plane.windows.push_back(*window);
    }
  }
  const double least = min_share * static_cast<double>(empty.at.size());
  planes.erase(std::remove_if(planes.begin() + static_cast<std::ptrdiff_t>(first), planes.end(),
                              [&](const PlaneWindows& plane) { return static_cast<double>(plane.windows.size()) < least; }),
               planes.end());
}

}  // namespace fransac::calibration

// SPDX-License-Identifier: Apache-2.0
// Scalar truth of the cell kernels: as plain as can be, in double.
#include <algorithm>
#include <cmath>

#include "kernels/cells.h"

namespace fransac::kernels::ref {
namespace {

/// Calls visit(column, row, z) for every measurement of a cell, z in metres.
template <int kSide, class Raw, class Visitor>
void for_each_measurement(const CellRows<Raw>& rows, std::size_t cell, float metres_per_unit, Visitor visit) {
  for (int v = 0; v < kSide; ++v) {
    for (std::size_t u = cell * kSide; u < (cell + 1) * kSide; ++u) {
      const Raw raw = rows.rows[v][u];
      if (raw != Raw{0}) visit(u, v, static_cast<double>(raw) * static_cast<double>(metres_per_unit));
    }
  }
}

template <int kSide, class Raw>
std::size_t moments(const CellRows<Raw>& rows, std::size_t cells, float metres_per_unit, float least, const CellMoments& out) {
  constexpr double kSamples = static_cast<double>(kCell) / kSide;  // in the length of a pixel
  constexpr double kSquared = kSamples * kSamples;
  constexpr double kCentre = 0.5 * (kSide - 1);
  std::size_t measured = 0;
  for (std::size_t c = 0; c < cells; ++c) {
    double n = 0.0;
    double sum_u = 0.0;
    double sum_v = 0.0;
    double sum_q = 0.0;
    const double centre_u = static_cast<double>(c * kSide) + kCentre;
    for_each_measurement<kSide>(rows, c, metres_per_unit, [&](std::size_t u, int v, double z) {
      n += 1.0;
      sum_u += kSamples * (static_cast<double>(u) - centre_u);
      sum_v += kSamples * (v - kCentre);
      sum_q += 1.0 / z;
    });
    measured += static_cast<std::size_t>(n);
    out.n[c] = out.u[c] = out.v[c] = out.q[c] = out.uu[c] = out.uv[c] = out.vv[c] = out.du[c] = out.dv[c] = 0.0F;
    out.mean_squared_residual[c] = kNoFit;
    if (n * kSquared < static_cast<double>(least) || n == 0.0 || !(sum_q / n < static_cast<double>(kMostInverseDepth))) continue;
    double uu = 0.0;
    double uv = 0.0;
    double vv = 0.0;
    double uq = 0.0;
    double vq = 0.0;
    double qq = 0.0;
    for_each_measurement<kSide>(rows, c, metres_per_unit, [&](std::size_t column, int row, double z) {
      const double u = kSamples * (static_cast<double>(column) - centre_u) - sum_u / n;
      const double v = kSamples * (row - kCentre) - sum_v / n;
      const double q = 1.0 / z - sum_q / n;
      uu += u * u / n;
      uv += u * v / n;
      vv += v * v / n;
      uq += u * q / n;
      vq += v * q / n;
      qq += q * q / n;
    });
    const double det = uu * vv - uv * uv;
    if (!(det > static_cast<double>(kLeastSpread))) continue;
    const double du = (vv * uq - uv * vq) / det;
    const double dv = (uu * vq - uv * uq) / det;
    out.n[c] = static_cast<float>(n * kSquared);
    out.u[c] = static_cast<float>(sum_u / n);
    out.v[c] = static_cast<float>(sum_v / n);
    out.q[c] = static_cast<float>(sum_q / n);
    out.uu[c] = static_cast<float>(uu);
    out.uv[c] = static_cast<float>(uv);
    out.vv[c] = static_cast<float>(vv);
    out.du[c] = static_cast<float>(du);
    out.dv[c] = static_cast<float>(dv);
    out.mean_squared_residual[c] = static_cast<float>(std::max(0.0, qq - du * uq - dv * vq));
  }
  return measured;
}

double residual(const CellPlane& plane, std::size_t u, int v, double z) {
  const double q = static_cast<double>(plane.base) + static_cast<double>(plane.du) * static_cast<double>(u) +
                   static_cast<double>(plane.dv) * v;
  return z * q - 1.0;
}

bool belongs(double residual, double z, std::size_t cell, const CellTolerance& tolerance) {
  return std::abs(residual) * z <= static_cast<double>(tolerance.per_cell[cell]) * z * z + static_cast<double>(tolerance.floor_m);
}

template <int kSide, class Raw>
void label(const CellRows<Raw>& rows, std::size_t first, std::size_t cells, float metres_per_unit, const CellPlane* planes,
           std::size_t num_planes, const CellTolerance& tolerance, std::uint8_t* const* labels, CellRunEvidence* evidence) {
  for (std::size_t p = 0; p < num_planes; ++p) evidence[p].squared_residual = 0.0F;
  for (std::size_t c = first; c < first + cells; ++c) {
    for (std::size_t p = 0; p < num_planes; ++p) evidence[p].count[c - first] = 0;
    for (int v = 0; v < kSide; ++v) std::fill_n(labels[v] + c * kSide, kSide, std::uint8_t{0});
    for_each_measurement<kSide>(rows, c, metres_per_unit, [&](std::size_t u, int v, double z) {
      std::size_t best = num_planes;
      double least = 0.0;
      for (std::size_t p = 0; p < num_planes; ++p) {
        const double r = residual(planes[p], u, v, z);
        if (!belongs(r, z, c, tolerance) || (best < num_planes && std::abs(r) >= std::abs(least))) continue;
        best = p;
        least = r;
      }
      labels[v][u] = best < num_planes ? planes[best].label : std::uint8_t{255};
      if (best == num_planes) return;
      ++evidence[best].count[c - first];
      evidence[best].squared_residual += static_cast<float>(least * least);
    });
  }
}

template <int kSide, class Raw>
void label_none(const CellRows<Raw>& rows, std::size_t first, std::size_t cells, std::uint8_t* const* labels) {
  for (int v = 0; v < kSide; ++v) {
    for (std::size_t u = first * kSide; u < (first + cells) * kSide; ++u) {
      labels[v][u] = rows.rows[v][u] != Raw{0} ? std::uint8_t{255} : std::uint8_t{0};
    }
  }
}

template <int kSide, class Raw>
typename CellKernels<Raw>::Fits fits(const CellRows<Raw>& rows, std::size_t cell, float metres_per_unit, const CellPlane& plane,
                                     const CellTolerance& tolerance) {
  typename CellKernels<Raw>::Fits result{0, 0};
  for_each_measurement<kSide>(rows, cell, metres_per_unit, [&](std::size_t u, int v, double z) {
    ++result.measured;
    if (belongs(residual(plane, u, v, z), z, cell, tolerance)) ++result.fitting;
  });
  return result;
}

template <int kSide, class Raw>
constexpr CellKernels<Raw> kKernels{moments<kSide, Raw>, label<kSide, Raw>, label_none<kSide, Raw>, fits<kSide, Raw>};

template <class Raw>
const CellKernels<Raw>& kernels_of(int side) {
  return side == 8 ? kKernels<8, Raw> : side == 4 ? kKernels<4, Raw> : kKernels<2, Raw>;
}

}  // namespace

template <>
const CellKernels<std::uint16_t>& cell_kernels(int side) {
  return kernels_of<std::uint16_t>(side);
}
template <>
const CellKernels<float>& cell_kernels(int side) {
  return kernels_of<float>(side);
}

}  // namespace fransac::kernels::ref

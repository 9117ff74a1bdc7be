// SPDX-License-Identifier: Apache-2.0
#include "planes/covariance.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <limits>

#include "support.hpp"

namespace fransac {
namespace {

using Vector4 = Eigen::Vector4d;

Vector4 coefficients(const Plane& plane) { return {plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.d}; }

TEST(PlaneFromInverseDepth, IsThePlane) {
  RandomStream random = testing::test_random();
  for (int i = 0; i < 100; ++i) {
    const Plane plane = *make_plane(testing::unit_vector(random), testing::uniform(random, 0.1, 5.0));
    const auto estimate = plane_from_inverse_depth(-plane.normal / plane.d, Eigen::Matrix3d::Identity());
    ASSERT_TRUE(estimate.has_value());
    EXPECT_LT((coefficients(estimate->plane) - coefficients(plane)).norm(), 1e-12);
  }
}

TEST(PlaneFromInverseDepth, NothingWithoutAPlane) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(plane_from_inverse_depth(Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()).has_value());
  EXPECT_FALSE(plane_from_inverse_depth({0.0, kNaN, 1.0}, Eigen::Matrix3d::Identity()).has_value());
  EXPECT_FALSE(plane_from_inverse_depth({0.0, 0.0, 1.0}, kNaN * Eigen::Matrix3d::Identity()).has_value());
}

TEST(PlaneFromInverseDepth, TheNormalsLengthIsCertain) {
  const auto estimate = plane_from_inverse_depth({0.2, -0.4, 0.5}, Eigen::Vector3d(1e-4, 2e-4, 3e-4).asDiagonal());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(estimate->covariance);
  EXPECT_NEAR(solver.eigenvalues()[0], 0.0, 1e-15);
  EXPECT_GT(solver.eigenvalues()[1], 1e-5);
  const Eigen::Vector3d& n = estimate->plane.normal;
  EXPECT_LT((estimate->covariance * Vector4(n.x(), n.y(), n.z(), 0.0)).norm(), 1e-15);
}

TEST(PlaneFromInverseDepth, AgreesWithDifferences) {
  RandomStream random = testing::test_random();
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d a = testing::uniform_point(random, -1.0, 1.0);
    const auto plane_at = [](const Eigen::Vector3d& p) {
      return coefficients(plane_from_inverse_depth(p, Eigen::Matrix3d::Zero())->plane);
    };
    constexpr double kStep = 1e-6;
    Eigen::Matrix<double, 4, 3> jacobian;
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(c);
      jacobian.col(c) = (plane_at(a + step) - plane_at(a - step)) / (2.0 * kStep);
    }
    const Eigen::Matrix4d expected = jacobian * jacobian.transpose();
    const Eigen::Matrix4d found = plane_from_inverse_depth(a, Eigen::Matrix3d::Identity())->covariance;
    EXPECT_LT((found - expected).norm(), 1e-6 * expected.norm());
  }
}

/// Fits planes to noisy inverse depth many times: along the axes of the predicted covariance the deviations must have its
/// variances and be uncorrelated.
TEST(PlaneFromInverseDepth, PredictsTheSpreadOfFits) {
  constexpr int kFits = 3000;  // a variance is then known to 2.6 %
  constexpr double kSigma = 1.425e-3;
  const Camera camera = testing::small_camera(24, 18);
  const Plane plane = *make_plane({0.3, -0.7, -0.6}, 1.8);
  const Eigen::Vector3d truth = -plane.normal / plane.d;
  std::vector<Eigen::Vector3d> rays;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      rays.push_back(testing::ray(camera, u, v));
      sum += rays.back() * rays.back().transpose();
    }
  }
  const Eigen::Matrix3d inverse = sum.inverse();
  const auto predicted = plane_from_inverse_depth(truth, kSigma * kSigma * inverse);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(predicted->covariance);
  const Eigen::Matrix<double, 4, 3> axes = solver.eigenvectors().rightCols<3>();
  const Eigen::Vector3d deviations = solver.eigenvalues().tail<3>().cwiseSqrt();

  RandomStream random = testing::test_random();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (int fit = 0; fit < kFits; ++fit) {
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& r : rays) right += r * (truth.dot(r) + kSigma * random.normal());
    const auto estimate = plane_from_inverse_depth(inverse * right, Eigen::Matrix3d::Zero());
    const Vector4 error = coefficients(estimate->plane) - coefficients(plane);
    const Eigen::Vector3d whitened = (axes.transpose() * error).cwiseQuotient(deviations);
    spread += whitened * whitened.transpose() / kFits;
  }
  EXPECT_LT((spread - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 0.15) << spread;
}

}  // namespace
}  // namespace fransac

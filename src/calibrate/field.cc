// SPDX-License-Identifier: Apache-2.0
#include "calibrate/field.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include "calibrate/noise.hpp"

namespace fransac::calibration {
namespace {

constexpr int kUnknowns = 2 * kDistortionTerms;
using Coefficients = Eigen::Matrix<double, kUnknowns, 1>;
using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;

constexpr int kRobustRounds = 3;
constexpr double kCauchy = 2.0;          // of a plane's own scale: farther windows count for little
constexpr double kSharedWindows = 36.0;  // windows with one slow error among them: 6 x 6
constexpr double kMinScale = 1e-7;       // per metre: rendered depth
constexpr std::size_t kMinFolds = 3;
constexpr std::size_t kFolds = 5;
constexpr double kMinGain = 0.9;  // of the bend's r.m.s.: a field that leaves more on frames left out is none
constexpr int kSmoothReach = 2;   // means of 5 x 5 windows, 40 pixels of 640, are the smooth part
constexpr int kMinSmooth = 9;     // windows of these

/// One sigma of the coefficient of degree 2, per metre, that is tried: at 1 m from a tenth of a millimetre to three centimetres.
constexpr std::array kStrengths{1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2};

/// A plane's windows as a linear problem: q + M c is affine in (x, y).
class PlaneProblem {
 public:
  explicit PlaneProblem(const PlaneWindows& plane) : plane_(&plane) {
    const auto n = static_cast<Eigen::Index>(plane.windows.size());
    affine_.resize(n, 3);
    field_.resize(n, kUnknowns);
    q_.resize(n);
    weights_ = Eigen::VectorXd::Ones(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Window& w = plane.windows[static_cast<std::size_t>(i)];
      const std::array<double, kDistortionTerms> terms = distortion_terms(w.x, w.y);
      const Eigen::Map<const Eigen::Matrix<double, 1, kDistortionTerms>> row(terms.data());
      affine_.row(i) << 1.0, w.x, w.y;
      field_.row(i) << row, w.q * row;
      q_[i] = w.q;
    }
  }

  /// What is left of q + M c beside its best plane.
  [[nodiscard]] Eigen::VectorXd residual(const Coefficients& c) const {
    const Eigen::VectorXd corrected = q_ + field_ * c;
    const Eigen::MatrixX3d weighted = weights_.asDiagonal() * affine_;
    const Eigen::Matrix3d normal = affine_.transpose() * weighted;
    const Eigen::Vector3d plane = normal.ldlt().solve(weighted.transpose() * corrected);
    return corrected - affine_ * plane;
  }

  /// Windows that c leaves far from the plane count less from now on.
  void reweight(const Coefficients& c) {
    const Eigen::VectorXd r = residual(c);
    std::vector<double> sizes(static_cast<std::size_t>(r.size()));
    for (std::size_t i = 0; i < sizes.size(); ++i) sizes[i] = std::abs(r[static_cast<Eigen::Index>(i)]);
    constexpr double kToSigma = 1.4826;  // of a normal variable's median magnitude
    scale_ = std::max(kMinScale, kToSigma * median(sizes));
    weights_ = (1.0 + (r.array() / (kCauchy * scale_)).square()).square().inverse().matrix();
  }

  /// The sums of least squares, the plane's own three unknowns eliminated.
  void sum_up() {
    const double weight = 1.0 / (kSharedWindows * scale_ * scale_);
    const Eigen::MatrixXd weighted = weights_.asDiagonal() * field_;
    const Eigen::MatrixX3d weighted_affine = weights_.asDiagonal() * affine_;
    const Eigen::Matrix3d affine_normal = affine_.transpose() * weighted_affine;
    const auto solver = affine_normal.ldlt();
    const Eigen::Matrix<double, kUnknowns, 3> cross = weighted.transpose() * affine_;
    const Eigen::Vector3d affine_right = weighted_affine.transpose() * q_;
    normal_ = weight * (weighted.transpose() * field_ - cross * solver.solve(cross.transpose()));
    right_ = -weight * (weighted.transpose() * q_ - cross * solver.solve(affine_right));
  }

  /// The smooth part of the residual, per metre, at each window; not a number where too few are around it.
  [[nodiscard]] Eigen::VectorXd bend(const Coefficients& c) const {
    const Eigen::VectorXd r = residual(c);
    Eigen::VectorXd smooth(r.size());
    for (Eigen::Index i = 0; i < r.size(); ++i) {
      const Window& here = plane_->windows[static_cast<std::size_t>(i)];
      double sum = 0.0;
      double weight = 0.0;
      int count = 0;
      for (int row = here.row - kSmoothReach; row <= here.row + kSmoothReach; ++row) {
        for (int column = here.column - kSmoothReach; column <= here.column + kSmoothReach; ++column) {
          const Window* const near = plane_->find(row, column);
          if (near == nullptr) continue;
          const Eigen::Index k = near - plane_->windows.data();
          sum += weights_[k] * r[k];
          weight += weights_[k];
          ++count;
        }
      }
      smooth[i] = count >= kMinSmooth ? sum / weight : std::nan("");
    }
    return smooth;
  }

  [[nodiscard]] std::size_t frame() const { return plane_->frame; }
  [[nodiscard]] double scale() const { return scale_; }
  [[nodiscard]] const Normal& normal() const { return normal_; }
  [[nodiscard]] const Coefficients& right() const { return right_; }

 private:
  const PlaneWindows* plane_;
  Eigen::MatrixX3d affine_;
  Eigen::Matrix<double, Eigen::Dynamic, kUnknowns> field_;
  Eigen::VectorXd q_;
  Eigen::VectorXd weights_;
  double scale_ = 1.0;
  Normal normal_ = Normal::Zero();
  Coefficients right_ = Coefficients::Zero();
};

/// How large coefficients are expected to be.
struct Prior {
  double strength_per_m = 0.0;
  bool gain = false;
};

/// Least squares with normal priors: higher degrees are expected to be smaller, so what no plane shows stays near zero.
Coefficients solve(const Normal& normal, const Coefficients& right, const Prior& prior, double typical_q) {
  Normal with_prior = normal;
  int term = 0;
  for (int degree = 2; degree <= kDistortionDegree; ++degree) {
    for (int i = 0; i <= degree; ++i, ++term) {
      const double sigma = prior.strength_per_m * 2.0 / degree;
      with_prior(term, term) += 1.0 / (sigma * sigma);
      const double of_gain = prior.gain ? sigma / typical_q : 1e-9;  // as much at a typical depth; else none
      with_prior(kDistortionTerms + term, kDistortionTerms + term) += 1.0 / (of_gain * of_gain);
    }
  }
  return with_prior.ldlt().solve(right);
}

/// Sums over planes for which `counts(fold)` holds.
template <class Counts>
std::pair<Normal, Coefficients> sums(const std::vector<PlaneProblem>& planes, Counts&& counts) {
  std::pair<Normal, Coefficients> sum{Normal::Zero(), Coefficients::Zero()};
  for (std::size_t p = 0; p < planes.size(); ++p) {
    if (!counts(p)) continue;
    sum.first += planes[p].normal();
    sum.second += planes[p].right();
  }
  return sum;
}

/// Collects how far planes are bent, as if all were at one depth: triangulating sensors bend what is twice as far by four times
/// as much, and far planes would drown the others.
class BendSum {
 public:
  explicit BendSum(double typical_q) : metres_(1.0 / (typical_q * typical_q)) {}
  void add(const Eigen::VectorXd& smooth) {
    for (const double bend : smooth) {
      if (!std::isnan(bend)) sizes_.push_back(metres_ * std::abs(bend));
    }
  }
  [[nodiscard]] Bend result() {
    if (sizes_.empty()) return {};
    double squares = 0.0;
    for (const double size : sizes_) squares += size * size;
    const auto most = sizes_.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(sizes_.size() - 1));
    std::nth_element(sizes_.begin(), most, sizes_.end());
    return {std::sqrt(squares / static_cast<double>(sizes_.size())), *most};
  }

 private:
  double metres_;
  std::vector<double> sizes_;
};

/// How badly a plane is bent against its own noise; one window far off is not all.
double cost(const PlaneProblem& plane, const Eigen::VectorXd& smooth) {
  constexpr double kMost = 3.0;
  double sum = 0.0;
  for (Eigen::Index i = 0; i < smooth.size(); ++i) {
    if (!std::isnan(smooth[i])) sum += std::min(kMost * kMost, std::pow(smooth[i] / plane.scale(), 2));
  }
  return sum;
}

/// The planes of one frame.
using FramePlanes = std::span<const PlaneWindows>;

/// How many windows two planes have in common, depth and all; 0 unless that is more than half of what either has.
std::size_t common_windows(const PlaneWindows& a, const PlaneWindows& b) {
  constexpr double kAlike = 0.1;  // of inverse depth
  const auto common = static_cast<std::size_t>(std::count_if(a.windows.begin(), a.windows.end(), [&](const Window& window) {
    const Window* const there = b.find(window.row, window.column);
    return there != nullptr && std::abs(there->q - window.q) < kAlike * window.q;
  }));
  return 2 * common > a.windows.size() + b.windows.size() - common ? common : 0;
}

/// Whether two frames see about the same from about the same place: planes of the same outline and depth cover more than half of
/// what planes cover in either.
bool same_view(FramePlanes a, FramePlanes b) {
  std::size_t common = 0;
  std::size_t of_a = 0;
  std::size_t of_b = 0;
  for (const PlaneWindows& plane : a) of_a += plane.windows.size();
  for (const PlaneWindows& plane : b) of_b += plane.windows.size();
  for (const PlaneWindows& plane : a) {
    for (const PlaneWindows& other : b) common += common_windows(plane, other);
  }
  constexpr double kMost = 0.7;
  return static_cast<double>(common) > kMost * static_cast<double>(std::max(of_a, of_b));
}

/// Each plane's view, numbered from 0 by first appearance. Frames that see the same would only confirm that what is seen is not
/// flat.
std::vector<std::size_t> views_of(std::span<const PlaneWindows> planes) {
  std::vector<std::size_t> view_of;
  std::vector<FramePlanes> firsts;  // the first frame of each view
  for (std::size_t begin = 0, end = 0; begin < planes.size(); begin = end) {
    while (end < planes.size() && planes[end].frame == planes[begin].frame) ++end;
    const FramePlanes frame = planes.subspan(begin, end - begin);
    const auto known = std::find_if(firsts.begin(), firsts.end(), [&](FramePlanes first) { return same_view(first, frame); });
    view_of.insert(view_of.end(), frame.size(), static_cast<std::size_t>(known - firsts.begin()));
    if (known == firsts.end()) firsts.push_back(frame);
  }
  return view_of;
}

/// Each plane's coefficients from the frames of other folds.
std::vector<Coefficients> of_others(const std::vector<PlaneProblem>& planes, const std::vector<std::size_t>& fold_of,
                                    const std::vector<std::pair<Normal, Coefficients>>& others, const Prior& prior,
                                    double typical_q) {
  std::vector<Coefficients> of_fold;
  for (const auto& [normal, right] : others) of_fold.push_back(solve(normal, right, prior, typical_q));
  std::vector<Coefficients> result;
  for (std::size_t p = 0; p < planes.size(); ++p) result.push_back(of_fold[fold_of[p]]);
  return result;
}

Bend bend_of(const std::vector<PlaneProblem>& planes, const std::vector<Coefficients>& coefficients, double typical_q) {
  BendSum sum(typical_q);
  for (std::size_t p = 0; p < planes.size(); ++p) sum.add(planes[p].bend(coefficients[p]));
  return sum.result();
}

/// The costs of the folds' planes.
std::vector<double> costs_of(const std::vector<PlaneProblem>& planes, const std::vector<std::size_t>& fold_of, std::size_t folds,
                             const std::vector<Coefficients>& coefficients) {
  std::vector<double> costs(folds);
  for (std::size_t p = 0; p < planes.size(); ++p) costs[fold_of[p]] += cost(planes[p], planes[p].bend(coefficients[p]));
  return costs;
}

double sum_of(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// Whether costs have fallen in the folds for more than one of them by chance: Student's one-sided test, 95 %, of the logarithms
/// of their ratios.
bool surely_less(const std::vector<double>& costs, const std::vector<double>& before) {
  constexpr std::array kStudent{2.92, 2.35, 2.13};  // of 3, 4 and 5 folds
  const auto n = static_cast<double>(costs.size());
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < costs.size(); ++i) {
    if (!(before[i] > 0.0 && costs[i] > 0.0)) continue;  // nothing to see: counts as no change
    const double gain = std::log(before[i] / costs[i]);
    sum += gain;
    squares += gain * gain;
  }
  const double mean = sum / n;
  const double variance = std::max(0.0, squares / n - mean * mean) / (n - 1.0);
  return mean > kStudent[costs.size() - kMinFolds] * std::sqrt(variance);
}

}  // namespace

Field fit_field(std::span<const PlaneWindows> planes, int width, int height, bool wanted) {
  std::vector<PlaneProblem> problems(planes.begin(), planes.end());
  std::vector<double> inverse_depths;
  for (const PlaneWindows& plane : planes) {
    for (const Window& window : plane.windows) inverse_depths.push_back(window.q);
  }
  const double typical_q = median(inverse_depths);
  constexpr Prior kFirst{.strength_per_m = 3e-3, .gain = false};
  Coefficients all = Coefficients::Zero();
  for (int round = 0; round < kRobustRounds; ++round) {
    for (PlaneProblem& problem : problems) {
      problem.reweight(all);
      if (wanted) problem.sum_up();
    }
    if (!wanted) break;
    const auto [normal, right] = sums(problems, [](std::size_t) { return true; });
    all = solve(normal, right, kFirst, typical_q);
  }

  const std::vector<Coefficients> none(problems.size(), Coefficients::Zero());
  Field field;
  field.before = bend_of(problems, none, typical_q);
  field.after = field.before;

  const std::vector<std::size_t> view_of = views_of(planes);
  field.views = view_of.empty() ? 0 : 1 + *std::max_element(view_of.begin(), view_of.end());
  if (!wanted || field.views < kMinFolds) return field;
  const std::size_t folds = std::min(kFolds, field.views);
  std::vector<std::size_t> fold_of;
  for (const std::size_t view : view_of) fold_of.push_back(view * folds / field.views);
  std::vector<std::pair<Normal, Coefficients>> others;
  for (std::size_t fold = 0; fold < folds; ++fold) {
    others.push_back(sums(problems, [&](std::size_t p) { return fold_of[p] != fold; }));
  }

  const std::vector<double> before = costs_of(problems, fold_of, folds, none);
  double least = kMinGain * kMinGain * sum_of(before);
  std::optional<Prior> best;
  for (const bool gain : {false, true}) {
    for (const double strength : kStrengths) {
      const Prior prior{strength, gain};
      const std::vector<double> costs =
          costs_of(problems, fold_of, folds, of_others(problems, fold_of, others, prior, typical_q));
      if (sum_of(costs) >= least || !surely_less(costs, before)) continue;
      least = sum_of(costs);
      best = prior;
    }
  }
  if (!best) return field;
  field.after = bend_of(problems, of_others(problems, fold_of, others, *best, typical_q), typical_q);
  const auto [normal, right] = sums(problems, [](std::size_t) { return true; });
  const Coefficients found = solve(normal, right, *best, typical_q);
  field.distortion.width = width;
  field.distortion.height = height;
  for (int i = 0; i < kDistortionTerms; ++i) {
    const auto term = static_cast<std::size_t>(i);
    field.distortion.offset_per_m[term] = std::clamp(found[i], -kMaxDistortion, kMaxDistortion);
    if (best->gain) field.distortion.gain[term] = std::clamp(found[kDistortionTerms + i], -kMaxDistortion, kMaxDistortion);
  }
  return field;
}

}  // namespace fransac::calibration

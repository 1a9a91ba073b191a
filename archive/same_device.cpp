// SPDX-License-Identifier: BSD-3-Clause
#include "archive/same_device.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

namespace magimu {
namespace {

// 1/100 is the share of unmixed devices that may be doubted (Markov's inequality), as in
// change_search.h.
constexpr double kDecides = 100.0;
// Groups' means over the scatter within groups, along the line between them. A steady drift that is
// cut into two halves has 2 sqrt(3) = 3.5 of it, whatever its length and however sure; a random one
// less. Twice that is no drift.
constexpr double kApart = 7.0;
constexpr std::size_t kMostGroups = 8;   // devices in one; work
constexpr std::size_t kMostMarks = 100;  // recordings that are compared; work
constexpr int kSizes = 21;               // of g: 1, 4, ... 4^20, sizes of 1 to a million sigmas

using Groups = std::vector<std::size_t>;

std::size_t count_of(const Groups& group) {
  return group.empty() ? 0 : *std::ranges::max_element(group) + 1;
}

// The mean of some recordings, and the squares about it.
struct GroupMean {
  VectorXd mean;
  MatrixXd information;
  double squares = 0.0;
};

template <class In>
GroupMean mean_of(const std::vector<const DeviceMark::Part*>& parts, const In& in) {
  const Eigen::Index d = parts.front()->value.size();
  GroupMean out{VectorXd::Zero(d), MatrixXd::Zero(d, d)};
  VectorXd sum = VectorXd::Zero(d);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (!in(i)) continue;
    out.information += parts[i]->information;
    sum += parts[i]->information * parts[i]->value;
  }
  out.mean = out.information.llt().solve(sum);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (!in(i)) continue;
    const VectorXd left = parts[i]->value - out.mean;
    out.squares += left.dot(parts[i]->information * left);
  }
  return out;
}

std::vector<const DeviceMark::Part*> parts_of(const std::vector<DeviceMark>& marks,
                                              DeviceMark::Family family) {
  std::vector<const DeviceMark::Part*> out;
  for (const DeviceMark& m : marks) out.push_back(&m.parts[family]);
  return out;
}

// Values in coordinates in which a mean recording's standard deviations are 1.
std::vector<VectorXd> whitened(const std::vector<const DeviceMark::Part*>& parts) {
  MatrixXd mean = MatrixXd::Zero(parts.front()->value.size(), parts.front()->value.size());
  for (const DeviceMark::Part* p : parts) mean += p->information / double(parts.size());
  const MatrixXd U = mean.llt().matrixU();
  std::vector<VectorXd> out;
  for (const DeviceMark::Part* p : parts) out.emplace_back(U * p->value);
  return out;
}

// Groupings into 2, 3, ... groups: those two that add least to the squares are joined (Ward 1963).
std::vector<Groups> groupings(const std::vector<VectorXd>& points) {
  struct Cluster {
    VectorXd mean;
    std::vector<std::size_t> members;
  };
  std::vector<Cluster> clusters;
  for (std::size_t i = 0; i < points.size(); ++i) clusters.push_back({points[i], {i}});
  std::vector<Groups> out;
  while (clusters.size() > 1) {
    if (clusters.size() < points.size() && clusters.size() <= kMostGroups) {
      Groups group(points.size());
      for (std::size_t c = 0; c < clusters.size(); ++c) {
        for (const std::size_t i : clusters[c].members) group[i] = c;
      }
      out.push_back(std::move(group));
    }
    double least = std::numeric_limits<double>::infinity();
    std::size_t first = 0, second = 1;
    for (std::size_t a = 0; a < clusters.size(); ++a) {
      for (std::size_t b = a + 1; b < clusters.size(); ++b) {
        const auto na = double(clusters[a].members.size()), nb = double(clusters[b].members.size());
        const double cost =
            na * nb / (na + nb) * (clusters[a].mean - clusters[b].mean).squaredNorm();
        if (!(cost < least)) continue;
        least = cost;
        first = a;
        second = b;
      }
    }
    Cluster &a = clusters[first], &b = clusters[second];
    const auto na = double(a.members.size()), nb = double(b.members.size());
    a.mean = (na * a.mean + nb * b.mean) / (na + nb);
    a.members.insert(a.members.end(), b.members.begin(), b.members.end());
    clusters.erase(clusters.begin() + std::ptrdiff_t(second));
  }
  return out;
}

// The least distance between two groups' means over the scatter within them, along that line.
double least_separation(const std::vector<VectorXd>& points, const Groups& group) {
  const std::size_t k = count_of(group);
  std::vector<VectorXd> mean(k, VectorXd::Zero(points.front().size()));
  std::vector<double> count(k, 0.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    mean[group[i]] += points[i];
    count[group[i]] += 1.0;
  }
  for (std::size_t c = 0; c < k; ++c) mean[c] /= count[c];
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < k; ++a) {
    for (std::size_t b = a + 1; b < k; ++b) {
      const VectorXd line = (mean[a] - mean[b]).normalized();
      double squares = 0.0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (group[i] != a && group[i] != b) continue;
        squares += std::pow(line.dot(points[i] - mean[group[i]]), 2);
      }
      const double dof = count[a] + count[b] - 2.0;
      const double scatter = dof > 0.0 ? std::sqrt(std::max(1.0, squares / dof)) : 1.0;
      least = std::min(least, (mean[a] - mean[b]).norm() / scatter);
    }
  }
  return least;
}

// How often the group changes from one recording to the next.
std::size_t turns_of(const Groups& group) {
  std::size_t out = 0;
  for (std::size_t i = 1; i < group.size(); ++i) out += group[i] != group[i - 1];
  return out;
}

}  // namespace

double log_factor_that_decides() { return std::log(kDecides); }

std::optional<DeviceMark> mark_of(const Calibration& c) {
  if (c.trust.verdict == Verdict::kNo || c.parameters.mag.empty() || c.covariance.rows() < 18) {
    return std::nullopt;
  }
  DeviceMark out;
  const auto set = [&](DeviceMark::Family family, const VectorXd& value, const MatrixXd& V) {
    out.parts[family] = {value, V.llt().solve(MatrixXd::Identity(V.rows(), V.cols()))};
    return V.llt().info() == Eigen::Success && out.parts[family].information.allFinite();
  };
  const Matrix3& D = c.parameters.mag.front().distortion;
  const double s = std::cbrt(D.determinant());
  if (!(std::abs(s) > 0.0) || !std::isfinite(s)) return std::nullopt;
  // D / s has the determinant 1: its last element follows from the others.
  const Eigen::Map<const Vec<double, 9>> d(D.data());
  const Matrix3 inverse = D.inverse().transpose();
  const Eigen::Map<const Vec<double, 9>> gradient(inverse.data());
  const MatrixXd J = (MatrixXd::Identity(9, 9) - d * gradient.transpose() / 3.0).topRows(8) / s;
  const bool usable =
      set(DeviceMark::kDistortion, d.head<8>() / s,
          J * c.covariance.block(6, 6, 9, 9) * J.transpose()) &&
      set(DeviceMark::kHardIron, c.parameters.mag.front().bias, c.covariance.block(15, 15, 3, 3)) &&
      set(DeviceMark::kGyroscopeBias, c.parameters.gyr_bias, c.covariance.block(3, 3, 3, 3)) &&
      set(DeviceMark::kAccelerometerBias, c.parameters.acc_bias, c.covariance.block(0, 0, 3, 3));
  if (!usable) return std::nullopt;
  return out;
}

double log_factor_of_groups(const std::vector<DeviceMark>& marks, const Groups& group,
                            DeviceMark::Family family) {
  const std::size_t k = count_of(group);
  if (k < 2 || k >= marks.size()) return 0.0;
  const std::vector<const DeviceMark::Part*> parts = parts_of(marks, family);
  const auto d = double(parts.front()->value.size());
  const double all = double(marks.size() - 1) * d, between = double(k - 1) * d;
  double within = 0.0;
  for (std::size_t c = 0; c < k; ++c) {
    within += mean_of(parts, [&](std::size_t i) { return group[i] == c; }).squares;
  }
  const double whole = mean_of(parts, [](std::size_t) { return true; }).squares;
  const double left = std::max(within, all - between);  // they scatter by their sigmas at least
  const double u = left / (left + std::max(0.0, whole - within));
  std::vector<double> logs;
  for (int j = 0; j < kSizes; ++j) {
    const double g = std::pow(4.0, j);
    logs.push_back(0.5 * (all - between) * std::log1p(g) - 0.5 * all * std::log1p(g * u));
  }
  const double most = *std::ranges::max_element(logs);
  double sum = 0.0;
  for (const double l : logs) sum += std::exp(l - most);
  return most + std::log(sum / kSizes);
}

double log_factor_of_groups(const std::vector<DeviceMark>& marks, const Groups& group) {
  double out = 0.0;
  for (int f = 0; f < DeviceMark::kFamilies; ++f) {
    out += log_factor_of_groups(marks, group, DeviceMark::Family(f));
  }
  return out;
}

std::optional<TakingTurns> groups_that_take_turns(const std::vector<DeviceMark>& marks) {
  if (marks.size() < 3 || marks.size() > kMostMarks) {
    if (marks.size() < 3) return std::nullopt;
    std::vector<DeviceMark> some;  // as many neighbours in time as may be
    some.assign(marks.begin(), marks.begin() + kMostMarks);
    std::optional<TakingTurns> out = groups_that_take_turns(some);
    if (out) out->group.resize(marks.size(), out->groups);  // those were not looked at
    return out;
  }
  const std::vector<VectorXd> points = whitened(parts_of(marks, DeviceMark::kDistortion));
  const auto n = double(marks.size());
  std::optional<TakingTurns> best;
  for (const Groups& group : groupings(points)) {
    const std::size_t k = count_of(group);
    if (turns_of(group) < k || least_separation(points, group) < kApart) continue;
    // The best of at most k^n / k! groupings, and of as many numbers of groups.
    const double tried =
        n * std::log(double(k)) - std::lgamma(double(k) + 1.0) + std::log(double(kMostGroups - 1));
    const double log_factor = log_factor_of_groups(marks, group, DeviceMark::kDistortion) - tried;
    double other = -std::numeric_limits<double>::infinity();
    for (const auto family :
         {DeviceMark::kHardIron, DeviceMark::kGyroscopeBias, DeviceMark::kAccelerometerBias}) {
      other = std::max(other, log_factor_of_groups(marks, group, family) - std::log(3.0));
    }
    if (std::min(log_factor, other) < log_factor_that_decides()) continue;
    if (!best || log_factor > best->log_factor)
      best = TakingTurns{group, k, turns_of(group), log_factor};
  }
  return best;
}

}  // namespace magimu

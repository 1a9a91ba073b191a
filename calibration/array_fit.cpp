// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/array_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "calibration/model/parameter_names.h"
#include "calibration/motion/block_means.h"
#include "calibration/pipeline.h"
#include "graph/numerical_error.h"
#include "graph/parallel.h"

namespace magimu {
namespace {

constexpr double kArrayNodeRate = 25.0;  // Hz

// Distortion, bias and density of a magnetometer whose attitudes are known.
struct Alone {
  Matrix3 D;
  Vector3 bias;
  double density;
};

// mean_k = D C_k R_k' m + o, weighed by the number of samples.
Alone fitted_alone(const std::vector<const Recording*>& all, const Stage& few, std::size_t m) {
  using Vector4d = Eigen::Vector4d;
  const Values& values = few.result().values;
  const ModelSpec& spec = few.spec();
  const double offset = spec.mag_time_offset ? spec.mag_offset_s.back() : 0.0;
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 3> B = Eigen::Matrix<double, 4, 3>::Zero();
  double squares = 0.0, n = 0.0, rate = 0.0;
  for (std::size_t r = 0; r < all.size(); ++r) {
    const NodePlan& plan = few.plans()[r];
    const IntegratedRotation gyr(all[r]->gyr, spec.gyr_bias, spec.gyr_matrix_value);
    const std::vector<NodeMean> blocks = node_means(all[r]->mag[m], gyr, plan, offset);
    const Vector3 field = unit_field(values.at<double>(dip_of(plan.field)));
    rate = all[r]->mag[m].rate_hz();
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      if (blocks[k].count == 0) continue;
      const Rot3& nRb = values.at<Rot3>(R(plan.first + int(k)));
      Vector4d x;
      x << (blocks[k].at_node ? nRb.unrotate(field) : Vector3(blocks[k].C * nRb.unrotate(field))),
          1.0;
      const double weight = blocks[k].count;
      A += weight * x * x.transpose();
      B += weight * x * blocks[k].mean.transpose();
      squares += weight * blocks[k].mean.squaredNorm();
      n += 1.0;
    }
  }
  const Eigen::Matrix<double, 4, 3> X = A.ldlt().solve(B);
  // 4 numbers of each axis are fitted.
  const double left =
      std::max(0.0, squares - X.cwiseProduct(B).sum()) / std::max(3.0, 3.0 * n - 12.0);
  const Matrix3 D = X.topRows<3>().transpose();
  if (!X.allFinite() || !(rate > 0.0) || D.determinant() == 0.0) {
    throw NumericalError("the readings of " + all.front()->mag_names[m] +
                         " do not follow the motion");
  }
  return {D, X.row(3).transpose(), std::max(1e-9, std::sqrt(left / rate))};
}

}  // namespace

FewMagnetometers::FewMagnetometers(const std::vector<const Recording*>& all) : recordings_(all) {
  if (all.front()->mag.size() <= kFewMagnetometers) return;
  for (const Recording*& r : recordings_) {
    Recording& few = copies_.emplace_back();
    // Not by a copy of all.
    few.name = r->name;
    few.acc = r->acc;
    few.gyr = r->gyr;
    few.mag.assign(r->mag.begin(), r->mag.begin() + kFewMagnetometers);
    few.mag_names.assign(r->mag_names.begin(), r->mag_names.begin() + kFewMagnetometers);
    few.aux = r->aux;
    few.pos = r->pos;
    few.set_aside = r->set_aside;
    few.file_units = r->file_units;
    few.continues_previous = r->continues_previous;
    r = &few;
  }
}

int array_node_every(const Recording& recording, int fewest) {
  return std::max(fewest, int(std::ceil(recording.mag.front().rate_hz() / kArrayNodeRate)));
}

Stage fit_all_magnetometers(const std::vector<const Recording*>& all, const Stage& few, int every,
                            const OptimizerOptions& optimizer, bool noise_given) {
  const std::size_t magnetometers = all.front()->mag.size(), known = few.spec().mag_offset_s.size();
  std::vector<Alone> others(magnetometers - known);
  parallel::for_each(others.size(),
                     [&](std::size_t i) { others[i] = fitted_alone(all, few, known + i); });
  ModelSpec spec = few.spec();
  spec.mag_offset_s.resize(magnetometers, spec.mag_offset_s.back());
  for (const Alone& other : others) {
    spec.mag_noise.push_back(noise_given ? spec.noise.mag : other.density);
  }
  Stage out(all, spec, every, optimizer);
  Values start = carry_over(all, few, out);
  for (std::size_t i = 0; i < others.size(); ++i) {
    const int m = int(known + i);
    start.insert(key::distortion_of(m), others[i].D);
    start.insert(key::mag_bias_of(m), others[i].bias);
    if (spec.mag_time_offset) start.update(key::mag_time_offset_of(m), spec.mag_offset_s.back());
  }
  if (noise_given) {
    out.fit(start, true);
  } else {
    out.fit_noise(start, true,
                  {.gyr_known = true, .acc_known = true, .max_each_mag = largest_mag_noise(all)});
  }
  return out;
}

MissingEffect of_all_magnetometers(const MissingEffect& few, const ModelSpec& spec, int recordings,
                                   const Calibration& all) {
  const int known = int(spec.mag_offset_s.size()), last = known - 1;
  const std::vector<std::string> names = parameter_names(known, recordings, spec);
  const auto place = [&](const std::string& name) {
    return Eigen::Index(std::ranges::find(names, name) - names.begin());
  };
  // Rows: all parameters; columns: the few's.
  MatrixXd T = MatrixXd::Zero(Eigen::Index(all.order.size()), Eigen::Index(names.size()));
  for (std::size_t i = 0; i < all.order.size(); ++i) {
    const Eigen::Index from = place(all.order[i]);
    if (from < T.cols()) T(Eigen::Index(i), from) = 1.0;
  }
  const Eigen::Index of_last = 6 + 12 * Eigen::Index(last);
  const Matrix3 to_unit = all.parameters.mag[std::size_t(last)].distortion.inverse();
  for (std::size_t m = std::size_t(known); m < all.parameters.mag.size(); ++m) {
    const Matrix3 turned = all.parameters.mag[m].distortion * to_unit;
    for (Eigen::Index column = 0; column < 4; ++column) {  // of D, and the bias
      T.block<3, 3>(6 + 12 * Eigen::Index(m) + 3 * column, of_last + 3 * column) = turned;
    }
    const auto lag = std::ranges::find(all.order, time_offset_name(int(m)));
    if (lag != all.order.end()) T(lag - all.order.begin(), place(time_offset_name(last))) = 1.0;
  }
  MissingEffect out = few;
  out.shift = T * few.shift;
  out.covariance = T * few.covariance * T.transpose();
  return out;
}

}  // namespace magimu

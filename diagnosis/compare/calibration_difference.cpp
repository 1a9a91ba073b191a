// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/compare/calibration_difference.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "graph/decompositions.h"

namespace magimu {
namespace {

Eigen::Index index_of(const Calibration& c, const std::string& name) {
  const auto it = std::find(c.order.begin(), c.order.end(), name);
  return it == c.order.end() ? -1 : it - c.order.begin();
}

std::vector<Eigen::Index> indices_of(const Calibration& c, const std::vector<std::string>& names) {
  std::vector<Eigen::Index> out;
  for (const std::string& n : names) out.push_back(index_of(c, n));
  return out;
}

bool has_all(const std::vector<Eigen::Index>& at) {
  return std::all_of(at.begin(), at.end(), [](Eigen::Index i) { return i >= 0; });
}

// Of parameters that both calibrations have under these names, or nothing.
std::optional<Difference> plain(const Calibration& a, const Calibration& b,
                                const std::string& group, const std::vector<std::string>& names,
                                const VectorXd& d, const std::string& unit) {
  const auto ia = indices_of(a, names), ib = indices_of(b, names);
  if (!has_all(ia) || !has_all(ib)) return std::nullopt;
  return Difference{group,
                    names,
                    unit,
                    d,
                    a.covariance(ia, ia) + b.covariance(ib, ib),
                    a.covariance_model(ia, ia) + b.covariance_model(ib, ib)};
}

std::vector<std::string> three(const std::string& name) {
  return {name + "[0]", name + "[1]", name + "[2]"};
}

// The parts of M = s Q (I + E): log s; the turn, rad; E's xx, yy, xy, xz, yz.
VectorXd parts_of(const Matrix3& M) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(MatrixXd(M.transpose() * M));
  const Vector3 log_gain = 0.5 * solver.eigenvalues().array().log();
  const Matrix3 V = solver.eigenvectors();
  const double log_scale = log_gain.mean();
  const Vector3 gain = log_gain.array().exp();
  const Matrix3 Q = M * V * gain.cwiseInverse().asDiagonal() * V.transpose();
  const Vector3 turn = Rot3::from_matrix(Q).Log();
  const Matrix3 E = V * (log_gain.array() - log_scale).matrix().asDiagonal() * V.transpose();
  VectorXd out(9);
  out << log_scale, turn, E(0, 0), E(1, 1), E(0, 1), E(0, 2), E(1, 2);
  return out;
}

// Strength, turn and soft iron of one magnetometer.
void add_distortion(const Calibration& a, const Calibration& b, std::size_t m,
                    const std::string& of, std::vector<Difference>& out) {
  std::vector<std::string> names;
  for (int e = 0; e < 9; ++e) {
    names.push_back(fmt::format("magnetometers[{}].distortion[{}][{}]", m, e % 3, e / 3));
  }
  const auto ia = indices_of(a, names), ib = indices_of(b, names);
  if (!has_all(ia) || !has_all(ib)) return;
  const Matrix3 old = a.parameters.mag[m].distortion, now = b.parameters.mag[m].distortion;
  const VectorXd parts = parts_of(now * old.inverse());
  Eigen::Matrix<double, 9, 9> Ja, Jb;
  for (int e = 0; e < 9; ++e) {
    const double h = 1e-5 * old.norm();
    Matrix3 step = Matrix3::Zero();
    step(e % 3, e / 3) = h;
    Ja.col(e) = (parts_of(now * (old + step).inverse()) - parts_of(now * (old - step).inverse())) /
                (2.0 * h);
    Jb.col(e) = (parts_of((now + step) * old.inverse()) - parts_of((now - step) * old.inverse())) /
                (2.0 * h);
  }
  const auto combined = [&](const MatrixXd& Ca, const MatrixXd& Cb) -> MatrixXd {
    return Ja * Ca(ia, ia) * Ja.transpose() + Jb * Cb(ib, ib) * Jb.transpose();
  };
  const MatrixXd robust = combined(a.covariance, b.covariance);
  const MatrixXd model = combined(a.covariance_model, b.covariance_model);
  const auto add = [&](const std::string& group, int first, int n, double scale,
                       const std::string& unit, const std::vector<std::string>& parameters) {
    out.push_back({group + of, parameters, unit, scale * parts.segment(first, n),
                   scale * scale * robust.block(first, first, n, n),
                   scale * scale * model.block(first, first, n, n)});
  };
  add("soft_iron", 4, 5, 100.0, "%", {"xx", "yy", "xy", "xz", "yz"});
  add("mounting", 1, 3, 1.0 / kDegree, "deg", {"x", "y", "z"});
  // From the logarithm to the strength itself.
  const double before = std::cbrt(old.determinant()), after = before * std::exp(parts[0]);
  add("field_strength", 0, 1, after, "uT", {"strength"});
  out.back().d[0] = after - before;
}

}  // namespace

std::vector<Difference> differences(const Calibration& a, const Calibration& b) {
  std::vector<Difference> out;
  const auto add = [&](std::optional<Difference> d) {
    if (d) out.push_back(*std::move(d));
  };
  const std::size_t mags = std::min(a.parameters.mag.size(), b.parameters.mag.size());
  for (std::size_t m = 0; m < mags; ++m) {
    const std::string of = mags > 1 ? fmt::format("[{}]", m) : "";
    add(plain(a, b, "hard_iron" + of, three(fmt::format("magnetometers[{}].bias", m)),
              b.parameters.mag[m].bias - a.parameters.mag[m].bias, "uT"));
    add_distortion(a, b, m, of, out);
  }
  add(plain(a, b, "dip", {"field.dip_deg"},
            VectorXd::Constant(1, (b.parameters.dip_rad - a.parameters.dip_rad) / kDegree), "deg"));
  add(plain(a, b, "gyroscope_bias", three("gyroscope.bias"),
            b.parameters.gyr_bias - a.parameters.gyr_bias, "rad/s"));
  add(plain(a, b, "accelerometer_bias", three("accelerometer.bias"),
            b.parameters.acc_bias - a.parameters.acc_bias, "m/s^2"));
  for (const ActiveEffect& old : a.effects) {
    for (const ActiveEffect& now : b.effects) {
      if (old.name != now.name || old.parameters.size() != now.parameters.size()) continue;
      std::vector<std::string> names;
      VectorXd d(Eigen::Index(old.parameters.size()));
      for (std::size_t i = 0; i < old.parameters.size(); ++i) {
        names.push_back(old.parameters[i].name);
        d[Eigen::Index(i)] = now.parameters[i].value - old.parameters[i].value;
      }
      add(plain(a, b, old.name, names, d, old.parameters.front().unit));
    }
  }
  return out;
}

}  // namespace magimu

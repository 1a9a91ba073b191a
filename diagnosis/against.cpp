// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/against.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>

#include "diagnosis/change_text.h"

namespace magimu {
namespace {

constexpr double kBlock = 5.0;  // s, of the robust covariance

// d with its two covariances; gradients of d with respect to the calibrations' parameters make
// them.
struct Difference {
  std::string group;
  std::vector<std::string> names;
  std::string unit;
  VectorXd d;
  MatrixXd robust, model;
};

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
  const Matrix3 square = M.transpose() * M;
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(square);
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
  add("field_strength", 0, 1, std::cbrt(old.determinant()), "uT", {"strength"});
}

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

// d' C^-1 d over the directions that C knows; infinite where it is not a covariance.
double wald(const VectorXd& d, const MatrixXd& C) {
  const VectorXd scale = C.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd unit = scale.asDiagonal() * C * scale.asDiagonal();
  const VectorXd z = d.cwiseProduct(scale);
  return z.dot(unit.ldlt().solve(z));
}

double p_white(double statistic, double dof) {
  return boost::math::cdf(
      boost::math::complement(boost::math::chi_squared(dof), std::max(0.0, statistic)));
}

double p_robust(double statistic, double dof, double blocks) {
  const double left = std::max(2.0, blocks - dof);
  const double f = std::max(0.0, statistic) * left / (dof * std::max(1.0, blocks - 1.0));
  return boost::math::cdf(boost::math::complement(boost::math::fisher_f(dof, left), f));
}

Change judged(const Difference& difference, int blocks, double level) {
  const auto dof = double(difference.d.size());
  Change c{.group = difference.group, .dof = int(difference.d.size()), .unit = difference.unit};
  const double white = wald(difference.d, difference.model);
  const double robust = wald(difference.d, difference.robust);
  const double pw = p_white(white, dof), pr = p_robust(robust, dof, blocks);
  c.p_value = std::max(pw, pr);
  c.statistic = pr >= pw ? robust : white;
  c.changed = c.p_value < level;
  double widest = 0.0;
  for (Eigen::Index i = 0; i < difference.d.size(); ++i) {
    const double sigma = std::sqrt(std::max(difference.robust(i, i), difference.model(i, i)));
    widest = std::max(widest, sigma);
    c.parameters.push_back(
        {difference.names[std::size_t(i)], difference.d[i], sigma, difference.unit});
  }
  const double critical =
      boost::math::quantile(boost::math::complement(boost::math::chi_squared(dof), level));
  c.smallest = widest * (std::sqrt(critical) + 1.28);  // 1.28: nine times out of ten
  c.sentence = change_sentence(c);
  return c;
}

}  // namespace

bool Against::changed() const {
  return std::any_of(groups.begin(), groups.end(), [](const Change& c) { return c.changed; });
}

Against compare_calibrations(const Calibration& stored, const Calibration& now, int blocks,
                             double false_alarm_rate) {
  Against out;
  for (const auto& [c, which] : {std::pair(&stored, "stored"), std::pair(&now, "new")}) {
    for (const std::string& u : c->undetermined) {
      out.notes.push_back(
          fmt::format("Nothing can be compared: the {} calibration leaves open {}", which, u));
    }
  }
  if (!out.notes.empty()) return out;
  out.tested = true;
  const std::vector<Difference> all = differences(stored, now);
  for (const Difference& d : all) {
    out.groups.push_back(judged(d, blocks, false_alarm_rate / double(all.size())));
  }
  return out;
}

Against compare_with(const Calibration& stored, const std::string& stored_name,
                     const std::vector<const Recording*>& recordings, const AgainstOptions& given) {
  const auto has = [&](const std::string& name) {
    return std::any_of(stored.effects.begin(), stored.effects.end(),
                       [&](const ActiveEffect& e) { return e.name == name; });
  };
  CalibrationOptions options;
  options.noise = given.noise;
  options.gravity = stored.gravity;
  options.motion = stored.motion;
  options.mag_time_offset = has("mag_time_offset");
  options.gyr_matrix = has("gyro_scale_misalignment") && stored.motion == MotionModel::kHandHeld;
  const Calibration now = calibrate(recordings, options);
  double duration = 0.0;
  for (const Recording* r : recordings) duration += r->duration_s();
  Against out = compare_calibrations(stored, now, std::max(1, int(duration / kBlock)),
                                     given.false_alarm_rate);
  out.calibration = stored_name;
  const auto note_trust = [&](const Calibration& c, const std::string& which) {
    if (c.trust.verdict == Verdict::kNo) {
      out.notes.push_back(fmt::format("The {} calibration is not to be trusted: {}", which,
                                      c.trust.reasons.front()));
    }
  };
  note_trust(stored, "stored");
  note_trust(now, "new");
  for (const ActiveEffect& e : stored.effects) {
    if (e.name == "mag_time_offset" || e.name == "gyro_scale_misalignment") continue;
    out.notes.push_back(fmt::format(
        "{} is part of the stored calibration and was left out of the comparison.", e.name));
  }
  if (stored.fields.size() > 1 || now.fields.size() > 1) {
    out.notes.push_back("Dips are compared between single recordings only.");
  }
  return out;
}

}  // namespace magimu

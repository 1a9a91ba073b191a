// SPDX-License-Identifier: BSD-3-Clause
#include "navigation/navigation_output.h"

#include <fmt/format.h>

#include "graph/json_numbers.h"

namespace magimu {
namespace {

constexpr const char* kErrorNames[] = {"px", "py", "pz", "vx", "vy", "vz", "rx", "ry", "rz"};

}  // namespace

Eigen::Matrix<double, 9, 9> covariance_in_n(const NavigationRun& run, std::size_t k) {
  Eigen::Matrix<double, 9, 9> turn = Eigen::Matrix<double, 9, 9>::Identity();
  turn.bottomRightCorner<3, 3>() = run.states[k].nRb.matrix();
  return turn * run.covariances[k].topLeftCorner<9, 9>() * turn.transpose();
}

std::string navigation_csv(const NavigationRun& run) {
  std::string out = "t,qw,qx,qy,qz,vx,vy,vz,px,py,pz";
  for (int i = 0; i < 9; ++i) {
    for (int j = i; j < 9; ++j) out += fmt::format(",cov_{}_{}", kErrorNames[i], kErrorNames[j]);
  }
  out += '\n';
  for (std::size_t k = 0; k < run.t.size(); ++k) {
    const NavigationState& s = run.states[k];
    const Vector4& q = s.nRb.quaternion();
    out += fmt::format("{},{},{},{},{}", run.t[k], q[0], q[1], q[2], q[3]);
    for (const Vector3& v : {s.v, s.p}) out += fmt::format(",{},{},{}", v[0], v[1], v[2]);
    const Eigen::Matrix<double, 9, 9> P = covariance_in_n(run, k);
    for (int i = 0; i < 9; ++i) {
      for (int j = i; j < 9; ++j) out += fmt::format(",{:.9g}", P(i, j));
    }
    out += '\n';
  }
  return out;
}

nlohmann::ordered_json navigation_json(const NavigationRun& run) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  const auto numbers = [](const auto& of) { return json_numbers<nlohmann::ordered_json>(of); };
  for (std::size_t k = 0; k < run.t.size(); ++k) {
    const NavigationState& s = run.states[k];
    const Vector4& q = s.nRb.quaternion();
    const Eigen::Matrix<double, 9, 9> P = covariance_in_n(run, k);
    list.push_back({{"t", run.t[k]},
                    {"q", numbers(q)},
                    {"v", numbers(s.v)},
                    {"p", numbers(s.p)},
                    {"acc_bias", numbers(s.acc_bias)},
                    {"gyr_bias", numbers(s.gyr_bias)},
                    {"covariance", numbers(P)}});
  }
  return list;
}

}  // namespace magimu

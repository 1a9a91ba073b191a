// SPDX-License-Identifier: BSD-3-Clause
#include "navigation/navigate.h"

#include <fmt/format.h>

#include <ctime>

#include "recording/data/error.h"

namespace magimu {
namespace {

// Level by the specific force of a body at rest, yaw 0.
Rot3 level_attitude(const Vector3& acc) {
  const double roll = std::atan2(acc.y(), acc.z());
  const double pitch = std::atan2(-acc.x(), std::hypot(acc.y(), acc.z()));
  return Rot3::Exp({0.0, pitch, 0.0}) * Rot3::Exp({roll, 0.0, 0.0});
}

}  // namespace

NavigationRun navigate(const ArraySamples& samples, const NavigationOptions& options) {
  const std::clock_t began = std::clock();
  ArrayFilter filter(options.filter, samples.positions);
  NavigationState state;
  state.nRb = level_attitude(samples.acc.front());
  if (options.start) {
    state.p = options.start->p;
    state.v = options.start->v;
    state.nRb = options.start->nRb;
  }
  state.theta = VectorXd::Zero(filter.transport().basis().size());
  filter.start(state);

  NavigationRun run;
  bool field_known = false;
  for (std::size_t k = 0; k < samples.t.size(); ++k) {
    if (k > 0) {
      const bool given = k - 1 < options.linearize_field.size();
      filter.propagate(samples.acc[k - 1], samples.gyr[k - 1], samples.t[k] - samples.t[k - 1],
                       given ? &options.linearize_field[k - 1] : nullptr);
    }
    if (options.use_magnetometers && samples.measured[k]) {
      const VectorXd readings = samples.mag.col(static_cast<Eigen::Index>(k));
      if (!field_known) {  // the first readings start the field
        filter.start_field(readings);
        field_known = true;
      } else {
        run.innovations.push_back(filter.update(readings));
      }
    }
    if (samples.t[k] - samples.t.front() < options.aided_s && k < samples.true_p.size() &&
        samples.true_valid[k]) {
      filter.aid_position(samples.true_p[k], options.aid_sigma);
    }
    const auto covariance = filter.covariance().topLeftCorner<15, 15>();
    if (!filter.state().p.allFinite() || !filter.state().theta.allFinite() ||
        !covariance.allFinite()) {
      throw InputError(samples.name, 0, 0,
                       fmt::format("the filter diverged at {:.2f} s", samples.t[k]),
                       "look at the units of the readings (uT, m/s^2, rad/s) and at the layout");
    }
    run.t.push_back(samples.t[k]);
    run.states.push_back(filter.state());
    run.covariances.push_back(covariance);
  }
  run.seconds = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
  return run;
}

}  // namespace magimu

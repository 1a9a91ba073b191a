// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/scan/lacking_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "calibration/fit/disturbances/disturbance.h"
#include "calibration/model/parameter_names.h"
#include "graph/parallel.h"

namespace magimu {
namespace {

constexpr int kMostAskedNodes = 20000;  // half an hour at 12 a second: a few seconds of work
constexpr std::array kAskedParts = {DisturbedPart::kField, DisturbedPart::kMag, DisturbedPart::kGyr,
                                    DisturbedPart::kAcc};

std::string state_in_words(const DisturbanceFit& d) {
  constexpr const char* kWhere[] = {"the field about the magnetometer", "the magnetometer",
                                    "the gyroscope", "the accelerometer"};
  return fmt::format(
      "{} is disturbed by {:.2g} {} (standard deviation) for some {:.2g} s at a time, for a reason "
      "that this does not tell (the readings are more probable so by {:.0f} nats)",
      kWhere[std::size_t(d.part)], d.size, unit_of(sensor_of(d.part)), d.memory_s, d.gain_nats);
}

}  // namespace

std::optional<MissingEffect> find_lacking_state(const Stage& stage) {
  std::size_t nodes = 0;
  for (const NodePlan& plan : stage.plans()) nodes += plan.t.size();
  if (nodes > std::size_t(kMostAskedNodes)) return std::nullopt;
  std::array<std::optional<DisturbanceModel>, kAskedParts.size()> models;
  std::array<DisturbanceFit, kAskedParts.size()> fits;
  parallel::for_each(kAskedParts.size(), [&](std::size_t i) {
    models[i].emplace(stage, kAskedParts[i]);
    fits[i] = models[i]->fit();
  });
  const auto best =
      std::size_t(std::ranges::max_element(fits, {}, &DisturbanceFit::gain_nats) - fits.begin());
  if (!(fits[best].gain_nats > kNullGain)) return std::nullopt;

  const ModelSpec& spec = stage.spec();
  const int magnetometers = int(spec.mag_offset_s.size()), fields = stage.plans().back().field + 1;
  std::vector<double> shift;
  for (const Key key : parameter_keys(magnetometers, fields, spec)) {
    const VectorXd own = models[best]->shift(fits[best], key);
    const double unit = key.symbol == dip_of(0).symbol ? 1.0 / kDegree : 1.0;
    for (const double x : own) shift.push_back(unit * x);
  }
  MissingEffect out;
  out.name = to_string(sensor_of(kAskedParts[best])) + "_departure";
  out.channel = sensor_of(kAskedParts[best]);
  out.cause = state_in_words(fits[best]);
  out.shift = Eigen::Map<const VectorXd>(shift.data(), Eigen::Index(shift.size()));
  out.covariance = MatrixXd::Zero(out.shift.size(), out.shift.size());
  // Its mean is nothing that the recording tells from a bias: what switches on and off is not about
  // zero. A constant departure of the field is the field.
  if (kAskedParts[best] != DisturbedPart::kField) {
    out.covariance.diagonal()
        .segment<3>(first_of_bias(sensor_of(kAskedParts[best])))
        .setConstant(fits[best].size * fits[best].size);
  }
  return out;
}

}  // namespace magimu

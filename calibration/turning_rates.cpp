// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/turning_rates.h"

#include <fmt/format.h>

#include <algorithm>

#include "calibration/array_fit.h"
#include "calibration/fit/marginal_likelihood.h"
#include "calibration/motion/coning.h"
#include "calibration/motion/rests/rests.h"
#include "calibration/pipeline.h"
#include "graph/numerical_error.h"
#include "graph/parallel.h"

namespace magimu {
namespace {

// Squares in those of the noise: five standard deviations, all samples together.
constexpr double kMatters = 25.0;

double density_of(const Recording& r, const CalibrationOptions& options) {
  if (options.noise) return options.noise->gyr;
  const double at_rest = noise_at_rest(r, find_rests(r)).gyr;
  return at_rest > 0.0 ? at_rest : least_noise(r.gyr);
}

// With few nodes, the hand's motion and lags of the other sensors in the model, which coning must
// not stand for; nothing where no fit can be made.
std::optional<double> log_likelihood_of(const std::vector<const Recording*>& recordings,
                                        const CalibrationOptions& options) {
  return attempt([&] {
    const FewMagnetometers few(recordings);
    const Pipeline pipeline(few.get(), options);
    const Stage prompt = pipeline.coarse_fit(MotionModel::kHandHeld);
    ModelSpec spec = prompt.spec();
    spec.mag_time_offset = true;
    spec.effects.push_back(find_effect("acc_time_offset"));
    const Stage lagging = pipeline.refit(prompt, spec);
    if (!lagging.result().converged()) throw NumericalError("no optimum was found");
    return log_marginal_likelihood(lagging);
  });
}

}  // namespace

TurningRates::TurningRates(const std::vector<const Recording*>& all,
                           const CalibrationOptions& options)
    : recordings_(all) {
  double squares = 0.0, fastest = 0.0;
  for (const Recording* r : all) {
    squares += squares_of_coning(r->gyr, density_of(*r, options));
    fastest = std::max(fastest, r->gyr.rate_hz());
  }
  if (squares < kMatters) return;
  std::vector<const Recording*> constant;
  for (const Recording* r : all) {
    Recording& copy = copies_.emplace_back(*r);
    copy.gyr = constant_rates(r->gyr);
    constant.push_back(&copy);
  }
  std::optional<double> as_given, as_means;
  parallel::invoke([&] { as_given = log_likelihood_of(all, options); },
                   [&] { as_means = log_likelihood_of(constant, options); });
  if (!as_means || (as_given && *as_given >= *as_means)) {
    copies_.clear();
    return;
  }
  recordings_ = constant;
  said_ = fmt::format(
      "At {:.3g} Hz the axis of turning moves between two samples of the gyroscope: they are "
      "taken as means of its rate (coning).",
      fastest);
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
#include "apps/options/prior_options.h"

#include <chrono>
#include <filesystem>

#include "apps/options/axes_of_calibration.h"
#include "apps/options/number_checks.h"
#include "calibration/fit/parameter_prior.h"
#include "calibration/result/calibration_json.h"
#include "recording/data/error.h"

namespace magimu::apps {
namespace {

double days_since(const std::string& path) {
  std::error_code error;
  const auto written = std::filesystem::last_write_time(path, error);
  if (error) return 0.0;
  const std::chrono::duration<double> age = std::filesystem::file_time_type::clock::now() - written;
  return std::max(0.0, age.count() / 86400.0);
}

}  // namespace

CalibrationOptions PriorArguments::read(const ReadingOptions& reading) const {
  CalibrationOptions options;
  const bool given = prior != "default" && prior != "none";
  if (!given && (has_age || has_drift)) {
    throw InputError(has_age ? "--prior-age" : "--prior-drift", 0, 0,
                     "it is about an older calibration, and none is given",
                     "name its file: --prior CAL.json");
  }
  options.prior = prior == "none" ? PriorKind::kNone : PriorKind::kUsual;
  if (!given) return options;
  const nlohmann::ordered_json file = read_calibration_json(prior);
  GivenPrior old{prior, calibration_from_json(file, prior), has_age ? age_days : days_since(prior),
                 drift};
  check_same_axes(file, prior, reading);
  if (old.calibration.trust.verdict == Verdict::kNo) {
    throw InputError(prior, 0, 0, "its verdict is `no`: it tells nothing of the device",
                     "name another one, or use --prior default");
  }
  if (old.calibration.covariance_in_blocks) {
    throw InputError(
        prior, 0, 0,
        "its covariance is in blocks: how the magnetometers' errors go together, which "
        "a prior needs, is not in it",
        "write it with `magimu calibrate --joint-covariance`");
  }
  options.prior = PriorKind::kGiven;
  options.given_prior = std::make_shared<const GivenPrior>(std::move(old));
  return options;
}

void add_prior_options(CLI::App& cmd, PriorArguments& arguments) {
  cmd.add_option("--prior", arguments.prior,
                 "what is known beforehand: default (usual parts: accelerometer bias 0.2 m/s^2, "
                 "hard iron 20 uT, scale and soft iron 5 %, standard deviations at the least; of "
                 "the field and the mounting nothing), none, or the file of an older calibration "
                 "of the device")
      ->capture_default_str()
      ->type_name("default|none|CAL.json");
  cmd.add_option_function<double>(
         "--prior-age",
         [&arguments](double days) {
           arguments.age_days = days;
           arguments.has_age = true;
         },
         "age of that calibration in days (default: since the file was written)")
      ->check(nonnegative_number())
      ->type_name("DAYS");
  cmd.add_option_function<double>(
         "--prior-drift",
         [&arguments](double times) {
           arguments.drift = times;
           arguments.has_drift = true;
         },
         "times the usual change since; 0: nothing has changed, and it is the same place")
      ->check(nonnegative_number())
      ->type_name("TIMES");
}

}  // namespace magimu::apps

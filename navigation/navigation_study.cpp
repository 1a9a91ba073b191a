// SPDX-License-Identifier: BSD-3-Clause
#include "navigation/navigation_study.h"

#include <algorithm>
#include <filesystem>

#include "navigation/truncation.h"
#include "recording/arrays/array_mat.h"
#include "sim/draws/random.h"

namespace magimu {

std::vector<NavigationCase> navigation_cases(const std::string& folder) {
  std::vector<std::string> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".mat") paths.push_back(entry.path().string());
  }
  std::ranges::sort(paths);
  std::vector<NavigationCase> cases;
  for (const std::string& path : paths) {
    auto file = read_array_mat(path);
    if (!file || !file->recording.truth || !file->start) continue;
    cases.push_back({std::move(file->recording),
                     published_array_layout(),
                     NavigationStart{file->start->p, file->start->v, file->start->nRb},
                     9.82,
                     {}});
  }
  return cases;
}

NavigationCase simulated_case(unsigned seed, double moment) {
  ArrayRoomOptions options;
  options.seed = seed;
  options.moment = moment;
  options.positions = published_array_layout();
  Recording recording = simulate_array(options);
  // The start departs from the truth by what the filter is told.
  const ArrayFilterOptions filter;
  RandomStream random(seed, RandomPurpose::kArrayStart);
  const auto draw = [&](double sigma) { return Vector3(sigma * random.normal3()); };
  const MotionTruth& truth = *recording.truth;
  NavigationStart start;
  start.p = truth.position.front() + draw(filter.position_sigma);
  start.nRb = truth.nRb.front() * Rot3::Exp(draw(filter.attitude_sigma));
  // The same seed without the noise of the magnetometers: the same walk in the same room.
  options.mag_noise = 0.0;
  const Recording exact = simulate_array(options);
  return {std::move(recording), options.positions, start, options.gravity,
          array_samples(exact, options.positions).mag};
}

std::vector<NavigationVariant> navigation_variants() {
  std::vector<NavigationVariant> variants;
  const auto add = [&](const char* name, StepReadings readings, bool constrained, bool coloured) {
    NavigationVariant variant{name, {}, readings, coloured};
    variant.options.filter.constrain_yaw = constrained;
    variants.push_back(variant);
  };
  add("inertial alone", StepReadings::kMean, false, false);
  variants.back().options.use_magnetometers = false;
  add("MAINS, as published", StepReadings::kHeld, false, false);
  add("OC-MAINS, as published", StepReadings::kHeld, true, false);
  add("OC-MAINS, as published, coloured", StepReadings::kHeld, true, true);
  add("MAINS, means of steps", StepReadings::kMean, false, false);
  add("OC-MAINS, means of steps", StepReadings::kMean, true, false);
  add("MAINS, means of steps, coloured", StepReadings::kMean, false, true);
  add("OC-MAINS, coloured, estimated gradients", StepReadings::kMean, true, true);
  variants.back().shrink_gradients = false;
  add("OC-MAINS, means of steps, coloured", StepReadings::kMean, true, true);
  return variants;
}

NavigationVariant at_true_field_variant() {
  NavigationVariant variant = navigation_variants().back();
  variant.shrink_gradients = false;
  variant.name += ", at the true field";
  variant.at_true_field = true;
  return variant;
}

NavigationStudyRow run_variant(const NavigationVariant& variant,
                               const std::vector<NavigationCase>& cases) {
  NavigationStudyRow row;
  double seconds = 0.0, recorded = 0.0;
  for (const NavigationCase& c : cases) {
    const ArraySamples samples = array_samples(c.recording, c.positions, variant.readings);
    NavigationOptions options = variant.options;
    options.start = c.start;
    options.filter.gravity = c.gravity;
    if (variant.coloured) {
      options.filter = with_truncation(options.filter, samples);
      options.filter.shrink_gradients = variant.shrink_gradients;
    }
    if (variant.at_true_field) {
      const ArrayFilter filter(options.filter, c.positions);
      for (Eigen::Index k = 0; k < c.exact_mag.cols(); ++k) {
        options.linearize_field.push_back(filter.fit_field(c.exact_mag.col(k)));
      }
    }
    const NavigationRun run = navigate(samples, options);
    seconds += run.seconds;
    recorded += run.t.back() - run.t.front();
    row.runs.push_back(navigation_metrics(run, samples));
  }
  row.summary = summarize(row.runs);
  row.times_real_time = seconds > 0.0 ? recorded / seconds : 0.0;
  return row;
}

}  // namespace magimu

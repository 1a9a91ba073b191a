// SPDX-License-Identifier: BSD-3-Clause
// How long must one turn the sensor, and how? The standard deviations against the seconds so far,
// of the paper's motion, its recommended sequence of half turns, a hand without a plan, and a
// person who follows the guidance of a stream.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/fit/summary.h"
#include "calibration/pipeline.h"
#include "study/experiments.h"
#include "study/method_table.h"
#include "study/rotation_model.h"
#include "study/streamed_person.h"

namespace magimu {
namespace {

constexpr double kMotionSeconds[] = {8, 12, 16, 20, 30, 45, 60, 90, 120, 180, 240, 320};
constexpr double kMotionRate = 80.0;
constexpr int kPeople = 5;
constexpr double kEnough = 0.0133;  // uT, of D: the bound of the paper's 322 s (rates_rmse.csv)

// What a person records who does what the sentences of a stream say.
Recording guided_recording(std::uint64_t seed, double seconds) {
  constexpr double kStill = 3.0, kReading = 0.25;  // s
  StreamingOptions options;
  options.noise = kPaperNoise;
  options.gravity = kStandardGravity;
  options.motion = MotionModel::kRotation;
  options.target.heading_deg = 1e-4;  // never enough: on and on
  StreamedPerson person(seed, kPaperNoise);
  StreamingCalibration stream(1, options);
  Recording out;
  out.name = fmt::format("guided person {}", seed);
  out.mag_names = {"mag"};
  out.mag.resize(1);
  std::string sentence;
  const auto feed = [&](const StreamSample& s) {
    out.acc.push_back(s.t, *s.acc);
    out.gyr.push_back(s.t, *s.gyr);
    out.mag.front().push_back(s.t, *s.mag.front());
    if (const auto update = stream.add(s)) sentence = update->guidance;
    return s.t >= seconds;
  };
  for (;;) {
    if (person.turn(Vector3::Zero(), kReading, feed)) return out;
    if (sentence.empty()) continue;
    const Vector3 axis = axis_of(sentence);
    const double length = axis.isZero() ? kStill : angle_of(sentence) / StreamedPerson::kPace;
    if (person.turn(person.sign() * axis, length, feed)) return out;
  }
}

Recording moved_recording(SimulatedMotion motion, std::uint64_t seed, double seconds) {
  SimulationOptions options;
  options.motion = motion;
  options.rate_hz = kMotionRate;
  options.duration_s = seconds;
  options.seed = seed;
  options.gravity = kStandardGravity;
  return simulate(options).recording;
}

// Standard deviations (root mean square of a group) of o_a, o_w, o_m, D.
std::array<double, 4> sigmas(const Recording& recording) {
  const CalibrationOptions options = rotation_model(kPaperNoise, kStandardGravity);
  std::array<double, 4> out{kNoValue, kNoValue, kNoValue, kNoValue};
  try {
    const CheckedRecordings checked({&recording});
    const Pipeline pipeline(checked.get(), options);
    const Stage coarse = pipeline.coarse_fit(MotionModel::kRotation);
    const Calibration c = summarize_model(checked.get(), coarse, options);
    if (!c.undetermined.empty() || !c.fit.converged()) return out;
    const VectorXd variance = c.covariance_model.diagonal();
    out = {std::sqrt(variance.head<3>().sum()), std::sqrt(variance.segment<3>(3).sum()),
           std::sqrt(variance.segment<3>(15).sum()), std::sqrt(variance.segment<9>(6).sum())};
  } catch (const std::runtime_error&) {  // too short so far
  }
  return out;
}

struct MovedPerson {
  std::string name;
  std::function<Recording(std::uint64_t seed, double seconds)> record;
};

}  // namespace

Study study_motion(const Experiment& x) {
  Study study;
  study.name = "motion";
  study.title = "How long, and how to turn the sensor";
  study.question =
      "The MAP's standard deviations (root of the sum of a group's variances, median over people) "
      "against the seconds so far, at 80 Hz and the paper's noise densities. paper: its "
      "simulation, "
      "six slow turns; sequence: the half turns that it recommends, at 1 rad/s; hand: turned "
      "without "
      "a plan; guided: a person who does what the sentences of a stream say, at 1 rad/s.";
  const auto moved = [](SimulatedMotion motion) {
    return [motion](std::uint64_t seed, double s) { return moved_recording(motion, seed, s); };
  };
  const MovedPerson people[] = {{"paper", moved(SimulatedMotion::kPaper)},
                                {"sequence", moved(SimulatedMotion::kSequence)},
                                {"hand", moved(SimulatedMotion::kHand)},
                                {"guided", guided_recording}};
  const int count = x.count(kPeople, 1);
  std::vector<double> seconds(std::begin(kMotionSeconds), std::end(kMotionSeconds));
  if (x.options.brief) seconds = {12, 20, 30, 60};
  StudyTable table{"sigmas",
                   "Standard deviations after so many seconds",
                   {"motion", "seconds", "o_a m/s^2", "o_w rad/s", "o_m uT", "D uT"},
                   {}};
  constexpr const char* kGroups[] = {"o_a", "o_w", "o_m", "D"};
  constexpr const char* kGroupUnits[] = {"m/s^2", "rad/s", "uT", "uT"};
  std::vector<StudyFigure> figures;
  for (int g = 0; g < 4; ++g) {
    figures.push_back({fmt::format("sigma_{}", kGroups[g]),
                       fmt::format("Standard deviation of {}", kGroups[g]),
                       "time, s",
                       kGroupUnits[g],
                       true,
                       true,
                       {}});
  }
  std::map<std::string, double> enough;
  for (std::size_t p = 0; p < std::size(people); ++p) {
    x.tell(people[p].name, double(p) / 4.0);
    // One recording a person; its beginnings are what is calibrated.
    std::vector<std::vector<std::array<double, 4>>> of(std::size_t(count),
                                                       {seconds.size(), std::array<double, 4>{}});
    for_each_data_set(count, x.runs.threads(), [&](int i) {
      const Recording all = people[p].record(std::uint64_t(i + 1), seconds.back());
      for (std::size_t s = 0; s < seconds.size(); ++s) {
        of[std::size_t(i)][s] = sigmas(slice(all, 0.0, seconds[s]));
      }
    });
    for (StudyFigure& figure : figures) figure.curves.push_back({people[p].name, {}, {}});
    for (std::size_t s = 0; s < seconds.size(); ++s) {
      std::vector<StudyCell> row{people[p].name, seconds[s]};
      for (std::size_t g = 0; g < 4; ++g) {
        std::vector<double> values;
        for (const auto& person : of) {
          values.push_back(std::isfinite(person[s][g]) ? person[s][g] : kUnbounded);
        }
        const double middle = median(values);
        row.push_back(std::isfinite(middle) ? middle : kNoValue);
        figures[g].curves.back().x.push_back(seconds[s]);
        figures[g].curves.back().y.push_back(std::isfinite(middle) ? middle : kNoValue);
        if (g == 3 && middle <= kEnough && !enough.contains(people[p].name)) {
          enough[people[p].name] = seconds[s];
        }
      }
      table.rows.push_back(row);
    }
  }
  study.tables.push_back(table);
  study.figures = figures;
  std::string reached;
  for (const MovedPerson& person : people) {
    const auto found = enough.find(person.name);
    reached += fmt::format("{}{} {}", reached.empty() ? "" : ", ", person.name,
                           found == enough.end() ? "never" : fmt::format("{:g} s", found->second));
  }
  study.findings.push_back(
      fmt::format("D's standard deviation is at most {:g} uT, the bound of the paper's 322 s, "
                  "after: {} (of the "
                  "times in the table; {} people each).",
                  kEnough, reached, count));
  const auto at = [&](const std::string& name, std::size_t group) {
    for (const std::vector<StudyCell>& row : table.rows) {
      if (std::get<std::string>(row[0]) != name || std::get<double>(row[1]) != 60.0) continue;
      return std::get<double>(row[2 + group]);
    }
    return kNoValue;
  };
  study.findings.push_back(fmt::format(
      "After 60 s D's standard deviation is {:.3g} uT by the sequence, {:.3g} guided, {:.3g} by a "
      "hand without a plan{}.",
      at("sequence", 3), at("guided", 3), at("hand", 3),
      std::isfinite(at("paper", 3))
          ? fmt::format(", {:.3g} by the paper's slow turns", at("paper", 3))
          : "; the paper's slow turns, about one axis so far, leave it undetermined"));
  return study;
}

}  // namespace magimu

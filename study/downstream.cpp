// SPDX-License-Identifier: BSD-3-Clause
// What a calibration is worth in metres: recordings of an array in a room, distorted as a simulated
// board distorts, corrected by each method's calibration of that board, through the navigation
// filter.
#include <fmt/format.h>

#include <cmath>

#include "navigation/navigation_study.h"
#include "recording/data/error.h"
#include "study/array_device.h"
#include "study/experiments.h"
#include "study/method_table.h"

namespace magimu {
namespace {

// A calibration with its name.
struct Candidate {
  std::string name;
  ArrayCalibration made;
};

std::vector<Candidate> candidates(const Experiment& x, const ArrayDevice& device, bool rivals) {
  std::vector<Candidate> out{{"exact", exact_calibration(device)},
                             {"none", no_calibration(device)}};
  std::vector<std::pair<std::string, Method>> methods{{"MAP", Method::kMap}};
  if (rivals) {
    methods.emplace_back("Kok", Method::kKok);
    methods.emplace_back("Wu", Method::kWu);
    methods.emplace_back("Wu as published", Method::kWuPublished);
  }
  std::vector<ArrayCalibration> made(methods.size());
  for_each_data_set(int(methods.size()), x.runs.threads(), [&](int i) {
    made[std::size_t(i)] = calibrate_array(device, methods[std::size_t(i)].second,
                                           int(device.simulation.recording.mag.size()));
  });
  for (std::size_t i = 0; i < methods.size(); ++i) {
    out.push_back({methods[i].first, std::move(made[i])});
  }
  return out;
}

// The filter that `magimu navigate` runs: means of steps, yaw constrained, coloured truncation.
NavigationVariant navigation_default() {
  NavigationVariant variant = navigation_variants().back();
  variant.name = "OC-MAINS";
  return variant;
}

struct NavigatedWith {
  double rmse_m = kNoValue, median_ratio = kNoValue, nees = kNoValue, times_real_time = kNoValue;
  std::vector<double> final_m;
  std::string error;
};

NavigatedWith navigate_with(const Experiment& x, const ArrayCalibration& made,
                            const ArrayDevice& device, const std::vector<NavigationCase>& cases) {
  NavigatedWith out;
  std::vector<NavigationStudyRow> rows(cases.size());
  std::vector<std::string> errors(cases.size());
  for_each_data_set(int(cases.size()), x.runs.threads(), [&](int i) {
    NavigationCase c = cases[std::size_t(i)];
    c.recording = corrected(made, as_measured(device, c.recording));
    try {
      rows[std::size_t(i)] = run_variant(navigation_default(), {c});
    } catch (const InputError& e) {
      errors[std::size_t(i)] = e.what();
    }
  });
  std::vector<NavigationMetrics> metrics;
  std::vector<double> speed;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!errors[i].empty()) {
      out.error = errors[i];
      out.final_m.push_back(kNoValue);
      continue;
    }
    metrics.push_back(rows[i].runs.front());
    out.final_m.push_back(metrics.back().final_3d_m);
    speed.push_back(rows[i].times_real_time);
  }
  if (metrics.empty()) return out;
  const NavigationSummary summary = summarize(metrics);
  out.rmse_m = summary.position_rmse;
  out.median_ratio = summary.median_final_over_distance;
  out.nees = summary.position_nees;
  out.times_real_time = median(speed);
  return out;
}

struct Rooms {
  std::string name;
  std::vector<NavigationCase> cases;
};

std::vector<Rooms> rooms_of(const Experiment& x, int count) {
  std::vector<Rooms> rooms;
  Rooms& own = rooms.emplace_back();
  own.name = "simulated room";
  for (int i = 1; i <= count; ++i) own.cases.push_back(simulated_case(unsigned(i)));
  if (x.options.recordings.empty()) return rooms;
  Rooms given{"given recordings", navigation_cases(x.options.recordings)};
  if (given.cases.empty()) {
    throw InputError(x.options.recordings, 0, 0, "there is no recording of an array with its truth",
                     "give a folder of MATLAB files of the OC-MAINS set");
  }
  rooms.push_back(std::move(given));
  return rooms;
}

ArrayDeviceOptions board(const Experiment& x) {
  ArrayDeviceOptions options;
  if (x.options.brief) {
    options.motion = SimulatedMotion::kSequence;  // all axes in a minute
    options.rate_hz = 20.0;
  }
  return options;
}

}  // namespace

Study study_downstream(const Experiment& x) {
  Study study;
  study.name = "downstream";
  study.title = "What a calibration is worth in metres";
  study.question =
      "An array is carried around a room for 8 s. Its readings are distorted as a simulated board "
      "distorts (Table I, 30 magnetometers), then corrected by the calibration that each method "
      "makes of 322 s of turning that board. The filter is that of `magimu navigate`. How far off "
      "is the end, against the exact calibration's?";
  x.tell("calibrations", 0.0);
  const ArrayDevice device = make_device(board(x));
  const std::vector<Candidate> all = candidates(x, device, true);
  StudyTable table{"navigation",
                   "Errors at the end of 8 s",
                   {"room", "calibration", "recordings", "RMSE m", "median of distance, %",
                    "NEES per coordinate", "RMSE over the exact one's", "times real time"},
                   {}};
  const std::vector<Rooms> rooms = rooms_of(x, x.count(10, 2));
  double share = 0.4;
  for (const Rooms& room : rooms) {
    NavigatedWith exact, map;
    for (const Candidate& candidate : all) {
      x.tell(room.name + ", " + candidate.name, share);
      share += 0.6 / double(rooms.size() * all.size());
      const NavigatedWith n = navigate_with(x, candidate.made, device, room.cases);
      if (candidate.name == "exact") exact = n;
      if (candidate.name == "MAP") map = n;
      table.rows.push_back({room.name, candidate.name, double(room.cases.size()), n.rmse_m,
                            100.0 * n.median_ratio, n.nees, n.rmse_m / exact.rmse_m,
                            n.times_real_time});
      if (!n.error.empty()) study.findings.push_back(candidate.name + ": " + n.error);
      if (!candidate.made.error.empty()) {
        study.findings.push_back(candidate.name + ": " + candidate.made.error);
      }
    }
    check_limit(study, room.name + ": RMSE with the MAP's calibration over the exact one's",
                map.rmse_m / exact.rmse_m, 0.0, 1.1);
    check_limit(study, room.name + ": times faster than real time, one thread",
                exact.times_real_time, 50.0, kUnbounded);
    study.findings.push_back(fmt::format(
        "{}: {:.3f} m at the end with the exact calibration, {:.3f} m with the MAP's ({:.2f} % and "
        "{:.2f} % of the distance, medians).",
        room.name, exact.rmse_m, map.rmse_m, 100.0 * exact.median_ratio, 100.0 * map.median_ratio));
  }
  study.tables.push_back(table);
  return study;
}

Study study_imu_grade(const Experiment& x) {
  Study study;
  study.name = "imu-grade";
  study.title = "Calibration with a worse IMU";
  study.question =
      "The paper calibrates its board with the mean of 32 IMUs and with one of them, and navigates "
      "with both calibrations: the errors hardly differ. Here: the same board, turned with an IMU "
      "of "
      "the published densities, and of those times the root of 32; then the same recordings in the "
      "simulated room.";
  x.tell("calibrations", 0.0);
  ArrayDeviceOptions averaged = board(x), single = averaged;
  single.noise.acc *= std::sqrt(32.0);
  single.noise.gyr *= std::sqrt(32.0);
  const ArrayDevice devices[] = {make_device(averaged), make_device(single)};
  ArrayCalibration made[2];
  for_each_data_set(2, x.runs.threads(), [&](int i) {
    made[i] = calibrate_array(devices[i], Method::kMap, averaged.magnetometers);
  });
  StudyTable errors{"calibration",
                    "Errors of the MAP, root mean square over the magnetometers",
                    {"IMU", "o_a m/s^2", "o_w rad/s", "o_m uT", "D uT"},
                    {}};
  const std::vector<NavigationCase> cases = rooms_of(x, x.count(8, 2)).front().cases;
  NavigatedWith n[2];
  for (int i = 0; i < 2; ++i) {
    x.tell(i == 0 ? "mean of 32" : "one of 32", 0.5 + 0.25 * i);
    const ArrayErrors e = array_errors(devices[i], made[i]);
    errors.rows.push_back({i == 0 ? "mean of 32" : "one of 32", e.acc_bias, e.gyr_bias,
                           e.mag_bias_uT, e.distortion_uT});
    n[i] = navigate_with(x, made[i], devices[i], cases);
    if (!made[i].error.empty()) study.findings.push_back(made[i].error);
  }
  StudyTable table{"navigation",
                   "Errors at the end, m: ours (8 s in the simulated room) and, for other "
                   "recordings, published (60 s of aid, then free)",
                   {"recording", "mean of 32", "one of 32", "ratio", "published recording",
                    "published, mean of 32", "published, one of 32", "published ratio"},
                   {}};
  const std::vector<PublishedGrade>& published = published_imu_grades();
  for (std::size_t i = 0; i < std::max(cases.size(), published.size()); ++i) {
    std::vector<StudyCell> row;
    if (i < cases.size()) {
      row = {fmt::format("room {}", i + 1), n[0].final_m[i], n[1].final_m[i],
             n[1].final_m[i] / n[0].final_m[i]};
    } else {
      row = {std::string(), kNoValue, kNoValue, kNoValue};
    }
    if (i < published.size()) {
      const PublishedGrade& p = published[i];
      row.insert(row.end(), {StudyCell(std::string(p.recording)), p.averaged, p.single,
                             p.single / p.averaged});
    } else {
      row.insert(row.end(), {StudyCell(std::string()), kNoValue, kNoValue, kNoValue});
    }
    table.rows.push_back(row);
  }
  study.tables = {errors, table};
  const double factor = n[1].rmse_m / n[0].rmse_m;
  study.findings.push_back(fmt::format(
      "With the worse IMU D's error is {:.3g} uT instead of {:.3g}, and the RMSE at the end {:.3f} "
      "m instead of {:.3f} ({:.2f} times). Published, over 60 s of aid and a free rest: 0.98 to "
      "1.15 "
      "times.",
      std::get<double>(errors.rows[1][4]), std::get<double>(errors.rows[0][4]), n[1].rmse_m,
      n[0].rmse_m, factor));
  check_limit(study, "RMSE at the end, one of 32 over the mean of 32", factor, 0.0, 1.1);
  return study;
}

}  // namespace magimu

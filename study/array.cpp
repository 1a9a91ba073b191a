// SPDX-License-Identifier: BSD-3-Clause
// Thirty magnetometers on one IMU: all jointly, or each by itself as the paper does.
#include <fmt/format.h>

#include "study/array_device.h"
#include "study/experiments.h"
#include "study/method_table.h"

namespace magimu {
namespace {

struct ArrayRow {
  std::string name;
  Method method;
  bool pairs;
  int most;
};

}  // namespace

Study study_array(const Experiment& x) {
  Study study;
  study.name = "array";
  study.title = "Thirty magnetometers on one IMU";
  study.question =
      "A board as the paper's: 30 magnetometers, one IMU, 322 s at 62.5 Hz, the densities of its "
      "real run, a node every third sample. How good and how fast is each method, all "
      "magnetometers "
      "jointly, or each by itself with the IMU, as published? (The published recording is not "
      "public; its seconds stand beside.)";
  ArrayDeviceOptions options;
  options.magnetometers = x.options.brief ? 4 : 30;
  options.duration_s = x.options.brief ? 100.0 : 0.0;
  const ArrayDevice device = make_device(options);
  const int all = options.magnetometers;
  const ArrayRow rows[] = {
      {"MAP, jointly", Method::kMap, false, all},
      {"MAP, each by itself", Method::kMap, true, all},
      {"Wu, jointly", Method::kWu, false, all},
      {"Wu as published, each by itself", Method::kWuPublished, true, all},
      {"Kok, jointly", Method::kKok, false, all},
      {"Kok as published, each by itself", Method::kKokPublished, true, x.options.brief ? 1 : 2}};
  StudyTable table{"methods",
                   "Errors, root mean square over the magnetometers, and seconds for all of them "
                   "(where not all were calibrated: in proportion)",
                   {"method", "magnetometers calibrated", "o_a m/s^2", "o_w rad/s", "o_m uT",
                    "claimed", "D uT", "claimed", "seconds", "published seconds"},
                   {}};
  std::vector<ArrayErrors> errors(std::size(rows));
  std::vector<double> seconds(std::size(rows));
  std::vector<ArrayCalibration> made(std::size(rows));
  x.tell("calibrations", 0.1);
  for_each_data_set(int(std::size(rows)), x.runs.threads(), [&](int i) {
    const ArrayRow& row = rows[i];
    made[std::size_t(i)] = row.pairs && row.method == Method::kMap
                               ? calibrate_pairs(device, row.most)
                               : calibrate_array(device, row.method, row.most);
  });
  for (std::size_t i = 0; i < std::size(rows); ++i) {
    const ArrayErrors& e = errors[i] = array_errors(device, made[i]);
    seconds[i] = made[i].calibrated == 0 ? kNoValue : made[i].seconds * all / made[i].calibrated;
    table.rows.push_back({rows[i].name, double(made[i].calibrated), e.acc_bias, e.gyr_bias,
                          e.mag_bias_uT, e.mag_bias_sigma_uT, e.distortion_uT,
                          e.distortion_sigma_uT, seconds[i],
                          rows[i].pairs ? published_array_seconds(rows[i].method) : kNoValue});
  }
  study.tables.push_back(table);
  check_limit(study, "MAP jointly: D's error over that of each by itself",
              errors[0].distortion_uT / errors[1].distortion_uT, 0.0, 1.05);
  study.findings.push_back(fmt::format(
      "Jointly the MAP takes {:.1f} s for {} magnetometers, D's error is {:.3g} uT (claimed "
      "{:.3g}); "
      "each by itself {:.1f} s and {:.3g} uT: they share a trajectory, which all of them improve.",
      seconds[0], all, errors[0].distortion_uT, errors[0].distortion_sigma_uT, seconds[1],
      errors[1].distortion_uT));
  study.findings.push_back(fmt::format(
      "As published, each by itself: Wu D's error {:.3g} uT in {:.1f} s, Kok {:.3g} uT in {:.0f} s "
      "(in proportion from {}); published seconds: 23 and 5874 (20 processors).",
      errors[3].distortion_uT, seconds[3], errors[5].distortion_uT, seconds[5],
      made[5].calibrated));
  for (std::size_t i = 0; i < std::size(rows); ++i) {
    if (!made[i].error.empty()) study.findings.push_back(rows[i].name + ": " + made[i].error);
  }
  return study;
}

}  // namespace magimu

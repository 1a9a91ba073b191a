// SPDX-License-Identifier: BSD-3-Clause
// The paper's two sweeps: the rate of all sensors, and a magnetometer slower than the IMU.
#include <fmt/format.h>

#include <cmath>

#include "study/experiments.h"
#include "study/method_table.h"

namespace magimu {
namespace {

constexpr Method kSweepMethods[] = {Method::kMap, Method::kKok, Method::kWu, Method::kKokPublished,
                                    Method::kWuPublished};
// Data sets of a setting: the published figures' scatter is far wider than what more would tell.
constexpr int kWuSets = 20;
constexpr int kCappedSets = 4;  // of Kok as published, up to seven seconds each
constexpr const char* kNames[] = {"o_a", "o_w", "o_m", "D"};
constexpr const char* kUnits[] = {"m/s^2", "rad/s", "uT", "uT"};

// One setting of a sweep, by all methods.
struct SweepPoint {
  StudyCell label;
  double x = 0.0;
  MethodSetting setting;
  std::function<std::optional<PublishedRmse>(Method)> published;
  std::function<double(Method)> published_seconds;
  bool capped = true;  // Kok as published, too
};

// Of each method: RMSE of o_a, o_w, o_m, D and seconds against x, ours and published.
class SweepCurves {
 public:
  void add(Method method, double x, const MethodSummary& s,
           const std::optional<PublishedRmse>& published, double published_seconds) {
    const PublishedRmse ours = rmse_of(s);
    for (std::size_t g = 0; g < 4; ++g) {
      push(ours_[method][g], x, ours[g]);
      if (published) push(published_[method][g], x, (*published)[g]);
    }
    push(ours_[method][4], x, s.median_seconds);
    if (std::isfinite(published_seconds)) push(published_[method][4], x, published_seconds);
  }
  void draw(Study& study, const std::string& x_label, const std::string& suffix) const {
    for (std::size_t g = 0; g < 5; ++g) {
      StudyFigure figure;
      figure.name = (g < 4 ? std::string("rmse_") + kNames[g] : std::string("seconds")) + suffix;
      figure.title = g < 4 ? fmt::format("RMSE of {}", kNames[g]) : "Seconds a data set";
      figure.x_label = x_label;
      figure.y_label = g < 4 ? kUnits[g] : "s";
      figure.log_x = figure.log_y = true;
      for (const auto& [method, curves] : ours_) {
        figure.curves.push_back(curves[g]);
        figure.curves.back().name = to_string(method);
      }
      for (const auto& [method, curves] : published_) {
        figure.curves.push_back(curves[g]);
        figure.curves.back().name =
            "published " + std::string(method == Method::kMap            ? "MAP"
                                       : method == Method::kKokPublished ? "Kok"
                                                                         : "Wu");
        figure.curves.back().published = true;
      }
      study.figures.push_back(figure);
    }
  }

 private:
  static void push(StudyCurve& curve, double x, double y) {
    curve.x.push_back(x);
    curve.y.push_back(y);
  }
  std::map<Method, std::array<StudyCurve, 5>> ours_, published_;
};

// All methods at one point, into the study's last two tables; the MAP's summary.
MethodSummary compute(const Experiment& x, Study& study, StudyTable& rmse, StudyTable& methods,
                      SweepCurves& curves, const SweepPoint& point) {
  const std::string& label = std::get<std::string>(point.label);
  const std::vector<MethodRun>& map = x.runs.get(Method::kMap, point.setting);
  MethodSummary of_map;
  for (const Method method : kSweepMethods) {
    MethodSetting setting = point.setting;
    if (method == Method::kKokPublished) {
      if (!point.capped) continue;
      // The accuracy experiment has all of them at 10 Hz.
      setting.runs = std::min(setting.runs, kCappedSets);
    }
    if (method == Method::kWu || method == Method::kWuPublished) {
      setting.runs = std::min(setting.runs, kWuSets);
    }
    const MethodSummary s = summarize(x.runs.get(method, setting), map);
    const auto published = point.published(method);
    const double seconds = point.published_seconds(method);
    add_rmse(rmse, label, to_string(method), s, published);
    add_method(methods, label, to_string(method), s, seconds);
    curves.add(method, point.x, s, published, seconds);
    if (method == Method::kMap) of_map = s;
    if (method == Method::kMap || method == Method::kKok) {
      check_bands(study, to_string(method) + ", " + label, s);
    }
    if (method == Method::kKok) {
      check_limit(study, "Kok: median distance from the MAP, sigma, " + label, s.median_distance,
                  0.0, 0.05);
      check_limit(study, "Kok: largest distance from the MAP, sigma, " + label, s.largest_distance,
                  0.0, 0.1);
      check_limit(study, "Kok: most iterations, " + label, s.most_iterations, 0, 8);
    }
  }
  return of_map;
}

}  // namespace

Study study_rates(const Experiment& x) {
  Study study;
  study.name = "rates";
  study.title = "Sampling rates";
  study.question =
      "Do errors and seconds change with the rate? The paper's data sets at 10, 20, 40 and 80 Hz: "
      "the densities stay, so the noise of a sample grows with the root of the rate.";
  StudyTable rmse = rmse_table("rmse", "Errors at each rate", "rate");
  StudyTable methods = method_table("methods", "How each method went", "rate");
  SweepCurves curves;
  std::vector<MethodSummary> map;
  for (const double rate : kPublishedRates) {
    if (x.options.brief && rate > 20.0) break;
    x.tell(fmt::format("{:g} Hz", rate), (std::log2(rate / 10.0) + 0.1) / 4.0);
    SweepPoint point;
    point.label = fmt::format("{:g} Hz", rate);
    point.x = rate;
    point.setting.simulated.rate_hz = rate;
    point.setting.runs = x.count(x.options.runs, 4);
    point.published = [rate](Method m) { return published_rate_rmse(m, rate); };
    point.published_seconds = [rate](Method m) { return published_rate_seconds(m, rate); };
    point.capped = !x.options.brief || rate <= 10.0;
    map.push_back(compute(x, study, rmse, methods, curves, point));
  }
  study.tables = {rmse, methods};
  curves.draw(study, "rate, Hz", "");
  const MethodSummary &slow = map.front(), &fast = map.back();
  study.findings.push_back(fmt::format(
      "MAP: D's RMSE is {:.4g} uT at the lowest rate and {:.4g} at the highest; the bounds are "
      "{:.4g} and {:.4g}. With densities held the information hardly depends on the rate, as the "
      "paper found.",
      slow.groups[3].rmse, fast.groups[3].rmse, slow.groups[3].bound, fast.groups[3].bound));
  study.findings.push_back(fmt::format(
      "MAP: {:.3f} s a data set at the lowest rate, {:.3f} at the highest: {:.1f} times for {:g} "
      "times the samples (one thread of this machine; the published figures are another machine's, "
      "in MATLAB, Kok's with 20 processors).",
      slow.median_seconds, fast.median_seconds, fast.median_seconds / slow.median_seconds,
      x.options.brief ? 2.0 : 8.0));
  return study;
}

Study study_ratios(const Experiment& x) {
  Study study;
  study.name = "ratios";
  study.title = "A magnetometer slower than the IMU";
  study.question =
      "What does a magnetometer cost that gives every 2nd, 4th or 8th sample only (IMU at 80 Hz)? "
      "The paper does not say what stays: its noise density (a slower sensor averages) or the "
      "noise of a sample (samples are dropped). Both are simulated.";
  StudyTable rmse = rmse_table("rmse", "Errors at each ratio, in both readings", "ratio");
  StudyTable methods = method_table("methods", "How each method went", "ratio");
  SweepCurves density, sample;
  std::vector<MethodSummary> map[2];
  for (const int ratio : kPublishedRatios) {
    if (x.options.brief && ratio != 1 && ratio != 8) continue;
    for (const bool same_sample : {false, true}) {
      if (same_sample && ratio == 1) continue;  // the same thing
      x.tell(fmt::format("ratio {}", ratio), std::log2(ratio) / 4.0 + (same_sample ? 0.12 : 0.0));
      SweepPoint point;
      point.label = fmt::format("{}{}", ratio,
                                ratio == 1    ? ""
                                : same_sample ? ", same noise a sample"
                                              : ", same density");
      point.x = ratio;
      point.setting.simulated.rate_hz = x.options.brief ? 20.0 : 80.0;
      point.setting.simulated.mag_ratio = ratio;
      if (same_sample) point.setting.simulated.noise.mag *= std::sqrt(double(ratio));
      point.setting.runs = x.count(x.options.runs, 3);
      point.published = [ratio](Method m) { return published_ratio_rmse(m, ratio); };
      point.published_seconds = [ratio](Method m) { return published_ratio_seconds(m, ratio); };
      point.capped = !x.options.brief && !same_sample;
      const MethodSummary s =
          compute(x, study, rmse, methods, same_sample ? sample : density, point);
      map[same_sample ? 1 : 0].push_back(s);
    }
  }
  study.tables = {rmse, methods};
  density.draw(study, "IMU samples a magnetometer sample", "_same_density");
  sample.draw(study, "IMU samples a magnetometer sample", "_same_sample");
  const MethodSummary &one = map[0].front(), &slow = map[0].back(), &dropped = map[1].back();
  study.findings.push_back(fmt::format(
      "MAP, ratio 1 to 8, same density: o_m's RMSE {:.3g} to {:.3g} uT, D's {:.4g} to {:.4g}. Same "
      "noise a sample: {:.3g} and {:.4g} at ratio 8.",
      one.groups[2].rmse, slow.groups[2].rmse, one.groups[3].rmse, slow.groups[3].rmse,
      dropped.groups[2].rmse, dropped.groups[3].rmse));
  const double kept = slow.groups[2].rmse / one.groups[2].rmse,
               single = dropped.groups[2].rmse / one.groups[2].rmse;
  study.findings.push_back(fmt::format(
      "Published, o_m's RMSE stays within 1 % from ratio 1 to 8. Ours changes by a factor {:.3f} "
      "with the same density and {:.3f} with the same noise a sample; the published figure is "
      "closer "
      "to the same {}.",
      kept, single,
      std::abs(std::log(kept)) < std::abs(std::log(single)) ? "density" : "noise a sample"));
  return study;
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
#include "bench/real/real_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "apps/plot/plot.h"
#include "bench/real/orientation_filter.h"
#include "recording/files/atomic_file.h"

namespace magimu {
namespace {

constexpr int kPoints = 500;      // a line
constexpr double kCutBars = 8.0;  // deg

const char* yes_or_no(const Calibration& c) { return c.fit.converged() ? "" : " (not converged)"; }

double sigma_of(const Calibration& c, Eigen::Index first, Eigen::Index size) {
  return std::sqrt(c.covariance.diagonal().segment(first, size).sum());
}

// "44.49 ± 0.05": as many digits as the uncertainty has two of.
std::string with_sigma(double value, double sigma) {
  if (!(sigma > 0.0) || !std::isfinite(sigma)) return fmt::format("{:.3g}", value);
  const int digits = std::clamp(1 - int(std::floor(std::log10(sigma))), 0, 6);
  return fmt::format("{:.{}f} ± {:.{}f}", value, digits, sigma, digits);
}

std::string error_picture(const RealResult& r) {
  const MotionTruth& truth = *r.recording.truth;
  plot::Chart chart;
  chart.title = fmt::format("{} {}: orientation error against the cameras", r.number(), r.name());
  chart.x_label = "time, s";
  chart.y_label = "deg, logarithmic";
  chart.log_y = true;
  const auto add = [&](const char* name, const TrajectoryEstimate& trajectory,
                       plot::Colour colour) {
    const TimeSeries e = error_over_time(trajectory, truth, kPoints);
    chart.lines.push_back({.name = name, .x = e.t, .y = e.value, .colour = colour});
  };
  add("uncalibrated filter", r.uncalibrated_trajectory, plot::Colour::kGrey);
  add("rotation model (paper)", r.rotation.trajectories.front(), plot::Colour::kVermilion);
  add("magimu", r.ours.trajectories.front(), plot::Colour::kBlue);
  return plot::svg(chart);
}

std::string residual_picture(const RealResult& r) {
  plot::Chart chart;
  chart.title =
      fmt::format("{} {}: what the magnetometer reads beyond the model", r.number(), r.name());
  chart.x_label = "time, s";
  chart.y_label = "uT";
  const auto residual = mag_residual_over_time(r.recording, r.ours, kPoints);
  constexpr plot::Colour kColours[] = {plot::Colour::kBlue, plot::Colour::kVermilion,
                                       plot::Colour::kGreen};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    chart.lines.push_back({.name = std::string(1, "xyz"[axis]),
                           .x = residual[axis].t,
                           .y = residual[axis].value,
                           .colour = kColours[axis],
                           .width = 1.2});
  }
  for (const Disturbance& d : r.ours.disturbances) {
    chart.stretches.push_back({d.begin_s, d.end_s});
  }
  chart.stretches_name = "reported as magnetic disturbance";
  return plot::svg(chart);
}

std::string overview_picture(const RealStudy& study) {
  plot::BarChart chart;
  chart.title = "Orientation error against the cameras, deg RMS";
  chart.y_label = "deg";
  chart.cut = kCutBars;
  chart.bars = {{"uncalibrated filter", {}, plot::Colour::kGrey},
                {"rotation model (paper)", {}, plot::Colour::kVermilion},
                {"magimu", {}, plot::Colour::kBlue}};
  for (const RealResult& r : study.results) {
    std::string name = r.name();
    if (const auto space = name.find(' '); space != std::string::npos) name[space] = '\n';
    chart.groups.push_back(r.number() + "\n" + name);
    chart.bars[0].values.push_back(r.uncalibrated.total_deg);
    chart.bars[1].values.push_back(r.rotation_error.total_deg);
    chart.bars[2].values.push_back(r.ours_error.total_deg);
  }
  return plot::svg(chart);
}

}  // namespace

std::string orientation_table(const RealStudy& study) {
  std::string out =
      "| recording | uncalibrated filter | rotation model | **magimu** | heading, inclination | "
      "filter, rotation model's calibration | filter, magimu's calibration | motion | verdict |\n"
      "|---|---|---|---|---|---|---|---|---|\n";
  for (const RealResult& r : study.results) {
    out += fmt::format(
        "| {} {} | {:.2f} | {:.2f}{} | **{:.2f}**{} | {:.2f}, {:.2f} | {:.2f} | {:.2f} | {} | {} "
        "|\n",
        r.number(), r.name(), r.uncalibrated.total_deg, r.rotation_error.total_deg,
        yes_or_no(r.rotation), r.ours_error.total_deg, yes_or_no(r.ours), r.ours_error.heading_deg,
        r.ours_error.inclination_deg, r.rotation_filter.total_deg, r.ours_filter.total_deg,
        to_string(r.ours.motion), to_string(r.ours.trust.verdict));
  }
  return out;
}

std::string limits_table(const RealStudy& study) {
  std::string out =
      "| recording | as delivered | clock shifted | by, ms | both frames turned, too |\n"
      "|---|---|---|---|---|\n";
  for (const RealResult& r : study.results) {
    out += fmt::format("| {} {} | {:.2f} | {:.2f} | {:+.0f} | {:.2f} |\n", r.number(), r.name(),
                       r.parts.delivered_deg, r.parts.shifted_deg, r.parts.shift_ms,
                       r.parts.aligned_deg);
  }
  return out;
}

std::string parameter_table(const RealStudy& study) {
  std::string out =
      "| recording | o_a, m/s^2 | o_m, uT | σ of D, uT | dip, deg | strength, uT | lag, ms | "
      "gyroscope's matrix, % | residual, uT | time, s |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n";
  for (const RealResult& r : study.results) {
    const Calibration& c = r.ours;
    std::string lag = "none shown", matrix = "none shown";
    for (const ActiveEffect& effect : c.effects) {
      const auto& p = effect.parameters;
      if (effect.name == "mag_time_offset") {
        lag = with_sigma(1e3 * p.front().value, 1e3 * p.front().sigma);
      }
      if (effect.name != "gyro_scale_misalignment") continue;
      const auto largest = std::max_element(p.begin(), p.end(), [](const auto& a, const auto& b) {
        return std::abs(a.value) < std::abs(b.value);
      });
      matrix = with_sigma(100.0 * largest->value, 100.0 * largest->sigma);
    }
    out += fmt::format(
        "| {} {} | {} | {} | {:.2f} | {} | {} | {} | {} | {:.2f} | {:.1f} |\n", r.number(),
        r.name(), with_sigma(c.parameters.acc_bias.norm(), sigma_of(c, 0, 3)),
        with_sigma(c.parameters.mag.front().bias.norm(), sigma_of(c, 15, 3)), sigma_of(c, 6, 9),
        with_sigma(c.parameters.dip_rad / kDegree, c.fields.front().dip_sigma_rad / kDegree),
        with_sigma(c.strength_uT, c.strength_sigma_uT), lag, matrix, c.residuals[2].rms_unit,
        c.seconds);
  }
  return out;
}

std::string verdict_list(const RealStudy& study) {
  std::string out;
  for (const RealResult& r : study.results) {
    out += fmt::format("- **{} {}: {}**", r.number(), r.name(), to_string(r.ours.trust.verdict));
    for (const std::string& reason : r.ours.trust.reasons) out += "\n  - " + reason;
    out += "\n";
  }
  return out;
}

std::string cross_table(const RealStudy& study) {
  std::string out =
      "| recording | calibration | own calibration, deg | this one, deg | ratio | uncalibrated, "
      "deg |\n|---|---|---|---|---|---|\n";
  for (const CrossApplication& x : study.cross) {
    out +=
        fmt::format("| {} | of {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", x.applied, x.calibrated,
                    x.own_deg, x.other_deg, x.other_deg / x.own_deg, x.uncalibrated_deg);
  }
  return out;
}

std::string repeatability_table(const RealStudy& study) {
  const Repeatability& r = study.repeatability;
  const auto row = [](const char* name, const std::array<double, 2>& d, double sigmas) {
    return fmt::format("| {} | {:.3g} | {:.3g} | {:.2f} |\n", name, d[0], d[1], sigmas);
  };
  return "| parameters | difference, RMS | its σ, as reported | in σ, RMS |\n|---|---|---|---|\n" +
         row("o_a, m/s^2", r.difference[0], r.acc_bias) +
         row("o_m, uT", r.difference[1], r.mag_bias) +
         row("D / cbrt(det D)", r.difference[2], r.distortion) +
         fmt::format("| all | | | **{:.2f}** |\n", r.all);
}

std::string starts_table(const RealStudy& study) {
  std::string out = fmt::format(
      "| recording | same minimum | furthest of these, σ | elsewhere, not \"no\" | "
      "cos(dip) ≤ 0 | everything: same result | furthest, σ |\n|---|---|---|---|---|---|---|\n");
  for (const auto& [number, s] : study.starts) {
    out += fmt::format("| {} | {} of {} | {:.1e} | {} | {} | {} of {} | {:.2g} |\n", number, s.same,
                       s.starts, s.worst, s.trusted, s.wrong_sign, s.whole_same, s.starts,
                       s.whole_worst);
  }
  return out;
}

std::map<std::string, std::string> pictures(const RealStudy& study) {
  std::map<std::string, std::string> out;
  out["real_overview.svg"] = overview_picture(study);
  for (const RealResult& r : study.results) {
    out["real_" + r.number() + "_error.svg"] = error_picture(r);
    out["real_" + r.number() + "_residual.svg"] = residual_picture(r);
  }
  return out;
}

std::string with_block(const std::string& document, const std::string& name,
                       const std::string& content) {
  const std::string begin = "<!-- bench_real_data: " + name + " -->\n", end = "<!-- end -->";
  const std::size_t first = document.find(begin);
  const std::size_t last = first == std::string::npos ? first : document.find(end, first);
  if (last == std::string::npos) {
    throw std::runtime_error("the document has no block '" + name + "': add the lines\n" + begin +
                             end);
  }
  return document.substr(0, first + begin.size()) + "\n" + content + "\n" + document.substr(last);
}

void write_document(const RealStudy& study, const std::string& folder) {
  const std::string path = folder + "/real_data.md";
  std::ifstream file(path);
  std::string document{std::istreambuf_iterator<char>(file), {}};
  if (!file) throw std::runtime_error(path + " cannot be read");
  document = with_block(document, "orientation", orientation_table(study));
  document = with_block(document, "limits", limits_table(study));
  document = with_block(document, "parameters", parameter_table(study));
  document = with_block(document, "verdicts", verdict_list(study));
  document = with_block(document, "cross", cross_table(study));
  document = with_block(document, "repeatability", repeatability_table(study));
  if (!study.starts.empty()) document = with_block(document, "starts", starts_table(study));
  const auto svgs = pictures(study);
  std::filesystem::create_directories(folder + "/pictures");
  for (const auto& [name, svg] : svgs) write_atomically(folder + "/pictures/" + name, svg);
  write_atomically(path, document);
}

}  // namespace magimu

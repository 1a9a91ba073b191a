// SPDX-License-Identifier: BSD-3-Clause
#include "apps/say/calibration_table.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "apps/say/numbers.h"
#include "apps/say/parameter_words.h"
#include "diagnosis/result/sentence_words.h"

namespace magimu::apps {
namespace {

constexpr std::size_t kPrintedMagnetometers =
    4;  // magnetometers whose parameters are printed one by one

std::string in_columns(double value, double sigma) {
  const int n = decimals(sigma);
  return fmt::format("{:>12.{}f} ± {:<10.{}f}", value, n, sigma, n);
}

void add_vector(std::string& out, const Calibration& c, const std::string& label,
                const std::string& name, const Vector3& value, const std::string& unit) {
  const char* axes = "xyz";
  for (int i = 0; i < 3; ++i) {
    out += fmt::format("  {:<22}{}   {} {}\n", i == 0 ? label : "", axes[i],
                       in_columns(value[i], c.sigma(fmt::format("{}[{}]", name, i))), unit);
  }
}

void add_matrix(std::string& out, const Calibration& c, std::size_t m) {
  for (int i = 0; i < 3; ++i) {
    out += fmt::format("  {:<22}    ", i == 0 ? "distortion D" : "");
    for (int j = 0; j < 3; ++j) {
      const double sigma = c.sigma(fmt::format("magnetometers[{}].distortion[{}][{}]", m, i, j));
      out += in_columns(c.parameters.mag[m].distortion(i, j), sigma);
    }
    out += i == 0 ? " uT\n" : "\n";
  }
}

// The magnetometers of an array, a line each.
std::string array_table(const Calibration& c) {
  std::string out = fmt::format("  {:<10}{:>29}{:>10}{:>12}{:>12}{:>11}  {}\n", "", "bias, uT",
                                "gain, uT", "noise", "residual", "direction", "trust");
  out += fmt::format("  {:<10}{:>29}{:>10}{:>12}{:>12}{:>11}\n", "", "", "", "uT/sqrt(Hz)",
                     "(1: noise)", "deg");
  for (std::size_t m = 0; m < c.magnetometers.size(); ++m) {
    const MagnetometerRecord& own = c.magnetometers[m];
    const Vector3& bias = c.parameters.mag[m].bias;
    const double gain = std::cbrt(c.parameters.mag[m].distortion.determinant());
    out +=
        fmt::format("  {:<10}{:>9.3f} {:>9.3f} {:>9.3f}{:>10.3f}{:>12.3g}{:>12.3f}{:>11.2g}  {}\n",
                    c.mag_names[m], bias.x(), bias.y(), bias.z(), gain, own.noise,
                    own.residuals.rms, own.direction_sigma_deg, to_string(own.trust.verdict));
  }
  out += "  Each magnetometer's D, and all standard deviations, are in the file (-o).\n";
  for (std::size_t m = 0; m < c.magnetometers.size(); ++m) {
    for (const std::string& reason : c.magnetometers[m].trust.reasons) {
      out += fmt::format("  {}: {}\n", c.mag_names[m], reason);
    }
  }
  return out;
}

// "accelerometer bias o_a x", and the next component of the same as "y" alone.
void add_name(std::string& names, std::string& last, const std::string& name) {
  const std::size_t blank = name.rfind(' ');
  const std::string stem = name.substr(0, blank);
  const bool same = blank != std::string::npos && stem == last;
  names += (names.empty() ? "" : same ? " " : ", ") + (same ? name.substr(blank + 1) : name);
  last = stem;
}

// What the recording alone says about a parameter, next to what was known before.
std::string known_by_itself(const PriorRecord::Parameter& p) {
  constexpr double kNotKnown =
      100.0;  // times the sigma known before: the recording says next to nothing
  if (!(p.before < kNotKnown * p.sigma)) return "by itself not known";
  const std::string unit = calibration_parameter_unit(p.name);
  return "by itself known to " + two_figures(p.before) + (unit.empty() ? "" : " " + unit);
}

// Sentences about parameters that the prior, not the recording, determines; empty if there are
// none.
std::string said_of_prior(const Calibration& c) {
  constexpr double kShows = 0.9;  // ratio of sigmas: a change of a tenth is worth a line
  std::string held, nothing, last;
  for (const PriorRecord::Parameter& p : c.prior.parameters) {
    const std::string name = calibration_parameter_words(p.name, c.mag_names);
    if (p.after > kShows * p.sigma) {
      add_name(nothing, last, name);
    } else if (p.after < kShows * p.before) {
      held += fmt::format("{}{} ({})", held.empty() ? "" : ", ", name, known_by_itself(p));
    }
  }
  std::string out;
  if (!nothing.empty()) {
    out += fmt::format("This recording tells nothing of {}: that is what was known before ({}).\n",
                       nothing, c.prior.source);
  }
  if (!held.empty()) {
    out += fmt::format("What was known before ({}) tells more of {}.\n", c.prior.source, held);
  }
  if (c.prior.moved > 1.0) {
    out += fmt::format("It moved the calibration by {:.1f} of the recording's own sigmas.\n",
                       c.prior.moved);
  }
  return out.empty() ? out : out + "\n";
}

// A long label uses the blanks before its value but one.
std::string label_and_columns(const std::string& label, double value, double sigma) {
  constexpr std::size_t kLabel = 26;
  const std::string columns = in_columns(value, sigma);
  const std::size_t over = label.size() > kLabel ? label.size() - kLabel : 0;
  const std::size_t blanks = columns.find_first_not_of(' ');
  return fmt::format("{:<{}}", label, kLabel) +
         columns.substr(std::min(over, std::max<std::size_t>(blanks, 1) - 1));
}

// Of effects in the model: the effect's name once, a parameter's where there are several.
std::string effects_rows(const Calibration& c) {
  std::string out;
  for (const ActiveEffect& effect : c.effects) {
    std::string label = effect_words(effect.name);
    for (const ActiveEffect::Parameter& p : effect.parameters) {
      const std::string name =
          effect.parameters.size() > 1 ? calibration_parameter_words(p.name, c.mag_names) : "";
      out += fmt::format("  {} {}  {}\n", label_and_columns(label, p.value, p.sigma),
                         p.unit == "1" ? "" : p.unit, name);
      label.clear();
    }
  }
  return out;
}

std::string residuals_text(const Calibration& c) {
  std::string out = fmt::format(
      "Residuals (1 = as the noise predicts): acc {:.2f}, gyr {:.2f}, mag {:.2f} ({:.2f} uT)\n",
      c.residuals[0].rms, c.residuals[1].rms, c.residuals[2].rms, c.residuals[2].rms_unit);
  if (!is_moved(c.motion)) return out;
  return out +
         "  Of a sensor that is moved, the trajectory follows accelerometer and gyroscope:\n"
         "  their residuals say little, and far below 1 is as it should be. That of the\n"
         "  magnetometer says whether the model fits.\n";
}

}  // namespace

std::string calibration_table(const Calibration& c) {
  std::string out;
  out += fmt::format("{} samples, {} nodes, {} iterations, {:.2f} s; motion model: {}\n", c.samples,
                     c.nodes, c.fit.iterations, c.seconds, to_string(c.motion));
  if (!c.motion_reason.empty()) out += c.motion_reason + "\n\n";
  out += "Parameter                     value ± sigma (robust; IMU frame unless said)\n";
  add_vector(out, c, "accelerometer bias", "accelerometer.bias", c.parameters.acc_bias, "m/s^2");
  add_vector(out, c, "gyroscope bias", "gyroscope.bias", c.parameters.gyr_bias, "rad/s");
  const bool few = c.parameters.mag.size() <= kPrintedMagnetometers;
  if (c.magnetometers.size() > 1) out += array_table(c);
  for (std::size_t m = 0; m < c.parameters.mag.size() && few; ++m) {
    if (c.parameters.mag.size() > 1) out += fmt::format("  {}:\n", c.mag_names[m]);
    add_vector(out, c, "magnetometer bias", fmt::format("magnetometers[{}].bias", m),
               c.parameters.mag[m].bias, "uT");
    add_matrix(out, c, m);
  }
  for (const FieldEstimate& f : c.fields) {
    out += fmt::format("  {:<22}    {} deg{}\n", "dip (down positive)",
                       in_columns(f.dip_rad / kDegree, f.dip_sigma_rad / kDegree),
                       c.fields.size() > 1 ? "  " + f.recording : "");
  }
  out += effects_rows(c);
  for (const LeverArm& arm : c.lever_arms) {
    for (int i = 0; i < 3; ++i) {
      out += fmt::format("  {:<22}{}   {} m{}\n", i == 0 ? "lever arm" : "", "xyz"[i],
                         in_columns(arm.value[i], std::sqrt(arm.covariance(i, i))),
                         i == 0 && c.lever_arms.size() > 1 ? "  " + arm.recording : "");
    }
  }
  out += fmt::format("  {:<22}    {} uT\n", "field strength",
                     in_columns(c.strength_uT, c.strength_sigma_uT));
  if (c.earth_field) {
    out += fmt::format(
        "  {} at this place: {:.2f} uT, dip {:.2f} deg, declination {:.2f} deg (magnetic north "
        "lies\n  so far east of true north)\n",
        c.earth_field->model, c.earth_field->strength_uT, c.earth_field->dip_rad / kDegree,
        c.earth_field->declination_rad / kDegree);
  }
  if (!c.lever_arms.empty()) {
    out += fmt::format(
        "  The lever arm leads to the sensor from the point that it was turned about, which "
        "stayed\n"
        "  within {:.2f} m (a standard deviation).\n",
        c.reach_m);
  }
  if (c.motion == MotionModel::kTravelling) {
    out += fmt::format(
        "  The sensor travelled: beside a steady velocity along its own axes it moved at {:.2g} "
        "m/s\n"
        "  (a standard deviation of each axis); nothing is assumed of where it was.\n",
        c.speed_mps);
  }
  if (c.trust.verdict != Verdict::kNo) {
    out += "  To use it: the unit field in the IMU frame is D^-1 (mag - magnetometer bias).\n";
  }
  out += "\n" + said_of_prior(c);

  out +=
      fmt::format("Noise ({}), per sqrt(Hz): acc {:.3g} m/s^2, gyr {:.3g} rad/s, mag {:.3g} uT\n",
                  c.noise_given ? "given" : "estimated from rests and residuals", c.noise.acc,
                  c.noise.gyr, c.noise.mag);
  if (c.acc_jitter > 0.0) {
    out += fmt::format(
        "  Where the specific force changes fast, the accelerometer is believed less, as if its\n"
        "  samples were early or late by {:.0f} % of their interval; the readings are more "
        "probable so.\n",
        100.0 * c.acc_jitter);
  }
  out += residuals_text(c) + "\n";
  out += "Checks:\n";
  for (const Check& check : c.checks) {
    out += fmt::format("  {:<17} {:<8} {}\n", check.name, to_string(check.status), check.sentence);
  }
  out += "\n";
  for (const std::string& w : c.warnings) out += "Warning: " + w + "\n";
  out += fmt::format("Trust: {}\n", to_string(c.trust.verdict));
  for (const std::string& reason : c.trust.reasons) out += "  - " + reason + "\n";
  return plus_minus(out);
}

}  // namespace magimu::apps

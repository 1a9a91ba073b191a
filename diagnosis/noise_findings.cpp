// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/noise_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/finding_text.h"
#include "diagnosis/high_pass.h"
#include "diagnosis/noise_causes.h"
#include "diagnosis/noise_series.h"
#include "diagnosis/noise_tests.h"
#include "diagnosis/sample_residuals.h"
#include "diagnosis/unexplained.h"
#include "factors/effects/catalogue.h"
#include "graph/numerical_error.h"
#include "recording/quality.h"

namespace magimu {
namespace {

// Noise-like causes on the channels: each a test of its own.
constexpr double kTests = 12.0;
constexpr double kMinTails = 2.5;      // K of outliers
constexpr double kStrongLine = 1e-12;  // p
constexpr double kBelowLimit = 4.0;    // standard deviations of a sample

Finding to_finding(const NoiseTest& t) {
  Finding f;
  f.effect = t.effect;
  f.channel = to_string(t.channel);
  f.sentence = t.sentence;
  f.parameters = t.parameters;
  f.p_value = std::min(1.0, kTests * t.p_value);
  f.probability = 1.0 - f.p_value;
  f.gain = {.heldout_nll_before = t.nll_before,
            .heldout_nll_after = t.nll_after,
            .bic_delta = 2.0 * (t.nll_after - t.nll_before),
            .residual_rms_before = 1.0,
            .residual_rms_after = 1.0};
  return f;
}

// The correlation or the scale that would have been found; empty where no such number is known.
std::string detectable(const NoiseTest& t, double level) {
  if (t.parameters.empty()) return "";
  const double least = detectable_size(t.dof, std::log10(level)) * t.parameters.front().sigma;
  if (t.effect == "correlated_noise") return fmt::format("rho {:.1g}", least);
  if (t.effect == "noise_scale") return fmt::format("s {:.3g}", 1.0 + kDensityKnownTo + least);
  return "";
}

ScanEntry to_entry(const NoiseTest& t, double level) {
  ScanEntry e{.effect = t.effect, .channel = to_string(t.channel)};
  for (const FoundParameter& p : t.parameters) e.parameters.push_back(p.name);
  e.statistic = t.statistic;
  e.dof = t.dof;
  e.p_value = t.p_value;
  e.significant = t.untested.empty() && t.p_value < level;
  e.needs = t.untested;
  if (e.needs.empty() && !e.significant) e.detectable = detectable(t, level);
  return e;
}

// What coloured noise may imitate: a weak line, tails that are hardly heavier.
bool imitated_by_colour(const NoiseTest& t, const std::vector<NoiseTest>& all) {
  const bool coloured = std::any_of(all.begin(), all.end(), [&](const NoiseTest& o) {
    return o.effect == "correlated_noise" && o.channel == t.channel;
  });
  if (!coloured) return false;
  if (t.effect == "outliers") return t.parameters.size() > 1 && t.parameters[1].value < kMinTails;
  return t.effect == "mains_interference" && t.p_value > kStrongLine;
}

// Blows to a sensor that only turns: neither outliers, which come alone, nor the colour or the size
// of its noise. The hand's motion is no part of the model there.
bool shows_blows(const SampleResiduals& acc, const std::vector<NoiseTest>& all) {
  return !acc.high_passed && std::ranges::any_of(all, [](const NoiseTest& t) {
    return t.in_bursts && t.channel == Channel::kAcc && t.parameters[1].value > kMinTails;
  });
}

// The model with the alternating field in it, where that predicts better.
void extend_by_mains(const Pipeline& pipeline, Extender& extender, Finding& finding) {
  if (finding.effect != "mains_interference" || finding.parameters.size() < 7) return;
  ModelSpec spec = extender.stage().spec();
  spec.effects.push_back(make_mains_at(finding.parameters[6].value));
  // Without a fit of it the line stays a finding in the samples.
  attempt([&] {
    const Stage stage = pipeline.refit(extender.stage(), spec);
    if (stage.result().converged()) extender.replace(stage);
    return true;
  });
}

}  // namespace

std::optional<Finding> take_out_saturated(Recording& recording, const DiagnosisOptions& options) {
  VectorSeries& mag = recording.mag.front();
  if (mag.size() < 300) return std::nullopt;
  const SampleResiduals samples{.channel = Channel::kMag,
                                .t = mag.t,
                                .reading = mag.v,
                                .residual = high_passed(mag),
                                .high_passed = true};
  for (const NoiseTest& t : test_noise({samples})) {
    if (t.effect != "mag_saturation" || !t.untested.empty()) continue;
    if (t.p_value > options.false_alarm_rate / kTests) continue;
    const double limit = t.parameters.front().value;
    // Near the limit the samples that are left are those whose noise pointed away from it, and a
    // fit would take that for an error of the sensor. So all go whose neighbours are near it,
    // whatever the sample itself says: what the quadratic through them says at its time is the
    // reading less its high-passed part over 1 - c_0.
    const Vector3 margin =
        kBelowLimit *
        robust_scale(samples.residual, std::vector<char>(samples.residual.size(), 1)) /
        std::sqrt(kHighPassVariance);
    VectorSeries kept;
    for (std::size_t k = 0; k < mag.size(); ++k) {
      const Vector3 neighbours = mag.v[k] - samples.residual[k] / (1.0 - smoothing_weight(0));
      if (mag.v[k].cwiseAbs().maxCoeff() < limit * (1.0 - 1e-9) &&
          (neighbours.cwiseAbs() + margin).maxCoeff() < limit) {
        kept.push_back(mag.t[k], mag.v[k]);
      }
    }
    if (kept.size() < mag.size() / 2) return std::nullopt;
    mag = std::move(kept);
    return to_finding(t);
  }
  return std::nullopt;
}

void find_noise(const std::vector<const Recording*>& recordings, const Pipeline& pipeline,
                const DiagnosisOptions& options, Extender& extender, Diagnosis& d) {
  const double level = options.false_alarm_rate / kTests;
  const std::vector<SampleResiduals> residuals = sample_residuals(
      *recordings.front(), extender.stage(), 0, pipeline.rest_noise(), options.noise.has_value());
  const std::vector<NoiseTest> tests = test_noise(residuals);
  for (const NoiseTest& t : tests) d.scan.push_back(to_entry(t, level));
  std::vector<NoiseTest> causes = explain_noise(residuals, level);
  if (shows_blows(residuals.front(), tests)) {
    add_evidence(
        d, Channel::kAcc,
        "What sticks out of the accelerometer comes several samples at a time, as blows to "
        "the sensor make it: tapped, knocked, or put down?");
    std::erase_if(causes, [](const NoiseTest& t) { return t.channel == Channel::kAcc; });
  }
  for (const NoiseTest& t : causes) {
    if (imitated_by_colour(t, causes)) continue;
    if (int(d.findings.size()) >= options.max_findings) break;
    Finding f = to_finding(t);
    extend_by_mains(pipeline, extender, f);
    d.findings.push_back(std::move(f));
  }
}

void withdraw_lines_of_interpolation(const Recording& recording, Diagnosis& d) {
  const auto line = std::ranges::find(d.findings, "mains_interference", &Finding::effect);
  if (line == d.findings.end()) return;
  const double f_hz = line->parameters.back().value;
  if (is_mains(f_hz, recording.mag.front().rate_hz())) return;
  const bool interpolated = std::ranges::any_of(check_recording(recording), [](const Issue& i) {
    return i.kind == "interpolation" && i.sensor.starts_with("mag");
  });
  if (!interpolated) return;
  add_evidence(d, Channel::kMag,
               fmt::format("A line stands at {:.4g} Hz in the magnetometer's samples, which is "
                           "neither 50 nor 60 Hz. They are interpolated between measurements, "
                           "which makes such lines: it is not named mains.",
                           f_hz));
  d.findings.erase(line);
}

}  // namespace magimu

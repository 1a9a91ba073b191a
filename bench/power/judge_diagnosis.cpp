// SPDX-License-Identifier: BSD-3-Clause
// Findings against what was hidden: judge_diagnosis.h.
#include "bench/power/judge_diagnosis.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace magimu {
namespace {

bool has(const std::vector<std::string>& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

// The others of its class; no motion tells them apart.
std::string same_class(const std::string& effect) {
  if (effect == "mag_time_offset") return "mag_lag";
  if (effect == "mag_lag") return "mag_time_offset";
  return "";
}

std::vector<std::string> nested_in(const std::string& effect) {
  if (effect == "gyro_scale_misalignment") return {"clock_scale"};
  if (effect == "acc_scale_misalignment") return {"gravity"};
  if (effect == "mag_eddy_current") return {"mag_time_offset", "mag_lag", "mag_axis_time_offset"};
  // Three quarters of a sawtooth's power are its mean.
  if (effect == "mag_own_clock") return {"mag_time_offset", "mag_lag"};
  return {};
}

// What changes the noise belongs to one sensor; the others know theirs.
bool has_channel(oracle::EffectKind kind) {
  using enum oracle::EffectKind;
  return kind == kNoiseScale || kind == kCorrelatedNoise || kind == kOutliers;
}

// Frequencies are known up to a multiple of the rate and their sign, which turns the sine's.
struct Folded {
  double hz;
  double sign;
};
Folded folded(double hz, double rate_hz) {
  const double rest = hz - rate_hz * std::floor(hz / rate_hz);
  return rest <= 0.5 * rate_hz ? Folded{rest, 1.0} : Folded{rate_hz - rest, -1.0};
}

bool has_matrix_and_times(oracle::EffectKind kind) {
  using enum oracle::EffectKind;
  return kind == kMagChange || kind == kGyroChange || kind == kAccChange;
}

bool has_offset_and_times(oracle::EffectKind kind) {
  using enum oracle::EffectKind;
  return kind == kHardIronChange || kind == kAccBiasChange || kind == kGyroBiasChange;
}

// What a finding says of the nine entries of a change's matrix, and of its times: gains alone say
// nothing of the entries beside the diagonal, a turn nothing of the diagonal (sigma 0).
void put_into_matrix(const Finding& f, VectorXd& value, VectorXd& sigma) {
  value = VectorXd::Zero(11);
  sigma = VectorXd::Zero(11);
  for (const FoundParameter& p : f.parameters) {
    const int i = p.name.size() > 2 && p.name.find('[') != std::string::npos
                      ? p.name[p.name.find('[') + 1] - '0'
                      : 0;
    const auto put = [&](int at, double x) {
      value[at] = x;
      sigma[at] = p.sigma;
    };
    if (p.name.starts_with("C[")) put(3 * i + (p.name[5] - '0'), p.value);
    if (p.name.starts_with("k[")) put(4 * i, p.value);
    if (p.name.starts_with("phi[")) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;  // hat(phi)_kj = phi_i
      put(3 * k + j, p.value);
      put(3 * j + k, -p.value);
    }
    if (p.name == "t0") put(9, p.value);
    if (p.name == "t1") put(10, p.value);
  }
}

const oracle::Effect* truth_of(const HiddenCase& c, const std::string& name) {
  for (const oracle::Effect& e : c.options.effects) {
    if (e.name() == name) return &e;
  }
  return nullptr;
}

// The finding of this name, in the right channel where the effect has one.
const Finding* find_hidden(const Diagnosis& d, const HiddenCase& c, const std::string& name) {
  const oracle::Effect* truth = truth_of(c, name);
  for (const Finding& f : d.findings) {
    if (f.effect != name) continue;
    if (truth && has_channel(truth->kind) && f.channel != to_string(truth->channel)) continue;
    return &f;
  }
  return nullptr;
}

double gain_of(const Finding& f) {
  return std::max(0.0, f.gain.heldout_nll_before - f.gain.heldout_nll_after);
}

}  // namespace

bool Judgement::right() const {
  return std::all_of(naming.begin(), naming.end(),
                     [](Naming n) { return n == Naming::kRight || n == Naming::kSameClass; });
}

const Finding* find(const Diagnosis& d, const std::string& effect) {
  for (const Finding& f : d.findings) {
    if (f.effect == effect) return &f;
  }
  return nullptr;
}

std::string names_of(const Diagnosis& d) {
  std::string text;
  for (const Finding& f : d.findings) {
    if (!text.empty()) text += ", ";
    text += f.effect;
    if (f.effect == "noise_scale" || f.effect == "correlated_noise" || f.effect == "outliers") {
      text += " (" + f.channel + ")";
    }
  }
  if (d.unexplained.detected) text += text.empty() ? "unexplained" : ", unexplained";
  return text.empty() ? "nothing" : text;
}

double farthest_sigma(const Finding& f, const oracle::Effect& truth, const oracle::Options& o) {
  VectorXd theta = truth.parameters;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  VectorXd found(Eigen::Index(f.parameters.size())), sigma(found.size());
  for (Eigen::Index i = 0; i < found.size(); ++i) {
    found[i] = f.parameters[std::size_t(i)].value;
    sigma[i] = f.parameters[std::size_t(i)].sigma;
  }
  if (has_matrix_and_times(truth.kind)) put_into_matrix(f, found, sigma);
  const bool mains = truth.kind == oracle::EffectKind::kMainsInterference;
  if (mains && found.size() == 7) {
    const double rate = o.mag_rate_hz > 0.0 ? o.mag_rate_hz : o.rate_hz;
    const Folded a = folded(theta[6], rate), b = folded(found[6], rate);
    theta.segment<3>(3) *= a.sign;
    found.segment<3>(3) *= b.sign;
    theta[6] = a.hz;
    found[6] = b.hz;
  }
  // A lasting change is the same as its opposite until then.
  const bool change = has_offset_and_times(truth.kind) && found.size() == 5;
  if (change && !std::isfinite(theta[4]) && found[3] < 1.0) {
    found.head<3>() *= -1.0;
    found[3] = found[4];
    sigma[3] = sigma[4];
    found[4] = theta[4];
  }
  // The catalogue has a filter to second order in the rate, and of the accelerometer's gravity
  // alone.
  if (truth.kind == oracle::EffectKind::kMagBandwidth ||
      truth.kind == oracle::EffectKind::kAccBandwidth) {
    constexpr double kShape = 0.1;
    sigma[0] = std::hypot(sigma[0], kShape * theta[0]);
  }
  const bool drift = truth.kind == oracle::EffectKind::kFieldDrift ||
                     truth.kind == oracle::EffectKind::kAccBiasDrift ||
                     truth.kind == oracle::EffectKind::kMagGainDrift ||
                     truth.kind == oracle::EffectKind::kGyroGainDrift ||
                     truth.kind == oracle::EffectKind::kAccGainDrift ||
                     truth.kind == oracle::EffectKind::kHardIronDrift;
  double farthest = nan;
  for (Eigen::Index i = 0; i < found.size(); ++i) {
    // Terms of a drift beyond those hidden are 0; of those beyond what was fitted nothing is known.
    if (i >= theta.size() && !drift) return nan;
    const double expected = i < theta.size() ? theta[i] : 0.0;
    if (!std::isfinite(expected)) {  // a change that lasts: found to end after the recording
      if (std::isfinite(found[i]) && found[i] < o.motion.duration_s - 1.0) return 1e9;
      continue;
    }
    if (!(sigma[i] > 0.0)) continue;
    const double distance = std::abs(found[i] - expected) / sigma[i];
    farthest = std::isnan(farthest) ? distance : std::max(farthest, distance);
  }
  return farthest;
}

Judgement judge(const Diagnosis& d, const HiddenCase& c, const std::vector<std::string>& allowed) {
  Judgement j;
  std::vector<std::string> accepted = allowed;
  double gain_right = 0.0, gain_others = 0.0;
  for (const std::string& name : c.hidden) {
    const Finding* f = find_hidden(d, c, name);
    Naming naming = Naming::kRight;
    double farthest = std::numeric_limits<double>::quiet_NaN();
    accepted.push_back(name);
    if (f) {
      if (const oracle::Effect* truth = truth_of(c, name)) {
        farthest = farthest_sigma(*f, *truth, c.options);
      }
    } else if ((f = find(d, same_class(name)))) {
      naming = Naming::kSameClass;
      accepted.push_back(same_class(name));
    } else {
      naming = d.unexplained.detected ? Naming::kUnexplained : Naming::kNothing;
      for (const std::string& simpler : nested_in(name)) {
        if (!find(d, simpler)) continue;
        naming = Naming::kNested;
        accepted.push_back(simpler);
      }
    }
    if (f) gain_right += gain_of(*f);
    j.naming.push_back(naming);
    j.farthest_sigma.push_back(farthest);
  }
  if (c.moved()) accepted.push_back("linear_acceleration");
  for (const Finding& f : d.findings) {
    const bool right_name = has(accepted, f.effect);
    if (right_name && (!has(c.hidden, f.effect) || f.effect == "linear_acceleration" ||
                       find_hidden(d, c, f.effect) == &f)) {
      continue;
    }
    j.others.push_back(f.effect);
    gain_others += gain_of(f);
  }
  j.others_share = gain_others / std::max(gain_right, 1e-300);
  if (gain_right <= 0.0) j.others_share = j.others.empty() ? 0.0 : 1.0;
  for (Naming& naming : j.naming) {
    const bool missing = naming == Naming::kNothing || naming == Naming::kUnexplained;
    if (missing && !j.others.empty()) naming = Naming::kWrong;
  }
  return j;
}

std::vector<std::string> allowed_for(const std::string& outside_effect) {
  if (outside_effect == "sample_repetition" || outside_effect == "acc_tapping" ||
      outside_effect == "mag_time_jitter") {
    return {"correlated_noise", "outliers", "noise_scale"};
  }
  return {};
}

}  // namespace magimu

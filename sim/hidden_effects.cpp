// SPDX-License-Identifier: BSD-3-Clause
// Names and parameters of hidden effects: hidden_effects.h.
#include "sim/hidden_effects.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "factors/effects/catalogue.h"
#include "recording/data/error.h"
#include "sim/effect_sizes.h"

namespace magimu {
namespace {

using Parameters = std::vector<Effect::Parameter>;

[[noreturn]] void refuse(const std::string& problem, const std::string& remedy) {
  throw InputError("--effect", 0, 0, problem, remedy);
}

// Effects without a term, and those with parameters that a fit searches for.
struct Special {
  const char* name;
  Parameters parameters;    // besides those of the effect of this name
  bool replaces, on_noise;  // they stand alone; any sensor's noise may have it
};
const std::vector<Special>& specials() {
  static const std::vector<Special> all = [] {
    std::vector<Special> out = {{"linear_acceleration", {{"rms", "m", 0.0}}, true, false},
                                {"gyro_bias_drift", {{"q", "(rad/s)/sqrt(s)", 0.0}}, true, false},
                                {"mains_interference", {{"f", "Hz", 0.0}}, false, false},
                                {"noise_scale", {{"s", "1", 0.0}}, true, true},
                                {"correlated_noise", {{"rho", "1", 0.0}}, true, true},
                                {"outliers", {{"eps", "1", 0.0}, {"K", "1", 0.0}}, true, true},
                                {"mag_quantization", {{"q", "uT", 0.0}}, true, false},
                                {"mag_saturation", {{"M", "uT", 0.0}}, true, false}};
    for (const std::string& name : change_names()) {
      out.push_back({name.c_str(), {{"t0", "s", 0.0}, {"t1", "s", 0.0}}, false, false});
    }
    return out;
  }();
  return all;
}
const Special* find_special(const std::string& name) {
  const auto it = std::find_if(specials().begin(), specials().end(),
                               [&](const Special& s) { return s.name == name; });
  return it == specials().end() ? nullptr : &*it;
}

std::string joined(const std::vector<std::string>& words, const char* separator) {
  return fmt::format("{}", fmt::join(words, separator));
}

double number(const std::string& text, const std::string& effect) {
  double value = 0.0;
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || std::isnan(value)) {
    refuse(fmt::format("'{}' in the size of {} is no number", text, effect),
           fmt::format("write {0}, {0}=FACTOR or {0}=VALUE:VALUE:...", effect));
  }
  return value;
}

// a, b[0], ...: "a (uT), b[0] (m)"
std::string list(const Parameters& parameters) {
  std::vector<std::string> words;
  for (const auto& p : parameters) {
    words.push_back(p.unit == "1" ? p.name : fmt::format("{} ({})", p.name, p.unit));
  }
  return joined(words, ", ");
}

std::vector<double> checked(const EffectRequest& request, const Parameters& parameters,
                            bool family) {
  if (request.numbers.size() == parameters.size()) return request.numbers;
  refuse(
      fmt::format("{} numbers for {}", request.numbers.size(), request.name),
      fmt::format("give {}, separated by colons: {}{}",
                  family ? "three for each term of the drift" : std::to_string(parameters.size()),
                  list(parameters), parameters.size() == 1 ? ", with a colon behind it" : ""));
}

void check_range(const HiddenEffect& h) {
  const auto require = [&](bool holds, const char* what) {
    if (!holds)
      refuse(fmt::format("{} of {} is out of its range", h.parameters[0].name, h.name), what);
  };
  for (const auto& p : h.parameters) {
    if (p.name != "t0" && p.name != "t1") require(std::isfinite(p.value), "give finite numbers");
  }
  if (h.name == "mag_own_clock") require(h[0] >= 0.0, "give a period of 0 s or above");
  if (h.name == "mag_lag") require(h[0] > 0.0, "give a time constant above 0 s");
  if (h.name == "clock_scale") require(h[0] > -0.5, "give kappa above -0.5");
  if (h.name == "noise_scale") require(h[0] >= 0.0, "give a scale of 0 or above");
  if (h.name == "correlated_noise") require(std::abs(h[0]) < 1.0, "give rho between -1 and 1");
  if (h.name == "outliers") {
    require(h[0] >= 0.0 && h[0] <= 1.0, "give a probability, 0 to 1");
  }
  for (const char* name :
       {"gyro_bias_drift", "linear_acceleration", "mag_quantization", "mag_saturation"}) {
    if (h.name == name) require(h[0] >= 0.0, "give 0 or above");
  }
}

}  // namespace

std::vector<std::string> hidden_effect_names() {
  std::vector<std::string> names;
  for (const auto& effect : effect_catalogue()) names.push_back(effect->name());
  for (const Special& s : specials()) names.push_back(s.name);
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

EffectRequest parse_effect_request(const std::string& text) {
  EffectRequest request;
  const std::size_t equals = text.find('=');
  request.name = text.substr(0, equals);
  if (const std::size_t at = request.name.find('@'); at != std::string::npos) {
    const std::string channel = request.name.substr(at + 1);
    request.name.resize(at);
    for (const Sensor c : kSensors) {
      if (channel == to_string(c)) request.channel = c;
    }
    if (!request.channel) {
      refuse(fmt::format("'{}' is no sensor", channel), "write @acc, @gyr or @mag");
    }
  }
  const std::vector<std::string> names = hidden_effect_names();
  if (std::find(names.begin(), names.end(), request.name) == names.end()) {
    refuse(fmt::format("there is no effect '{}'", request.name),
           "known are " + joined(names, ", "));
  }
  if (equals == std::string::npos) return request;
  std::string sizes = text.substr(equals + 1);
  if (sizes.find(':') == std::string::npos) {
    request.factor = number(sizes, request.name);
    if (!std::isfinite(request.factor)) refuse("an infinite factor", "give a number such as 2");
    return request;
  }
  if (sizes.ends_with(':')) sizes.pop_back();
  for (std::size_t begin = 0; begin <= sizes.size();) {
    const std::size_t end = std::min(sizes.find(':', begin), sizes.size());
    request.numbers.push_back(number(sizes.substr(begin, end - begin), request.name));
    begin = end + 1;
  }
  return request;
}

namespace {

// Of a family the one with so many numbers; null where none has.
std::shared_ptr<const Effect> of_size(const Effect& family, std::size_t numbers) {
  for (int terms = 1; 3 * terms <= int(numbers); ++terms) {
    std::shared_ptr<const Effect> one = family.with_terms(terms);
    if (one && one->size() == int(numbers)) return one;
  }
  return nullptr;
}

}  // namespace

HiddenEffect hide(const EffectRequest& request, const SimulatedSurroundings& where) {
  std::shared_ptr<const Effect> effect = find_effect(request.name);
  const Special* special = find_special(request.name);
  if (!effect && !special) {
    refuse(fmt::format("there is no effect '{}'", request.name),
           "known are " + joined(hidden_effect_names(), ", "));
  }
  const bool alone = special && special->replaces;
  const bool family = !alone && effect->with_terms(1) != nullptr;
  if (family) {
    const auto asked = of_size(*effect, request.numbers.size());
    effect = asked ? asked : effect->with_terms(2);
  }
  Parameters parameters = alone ? Parameters{} : effect->description().parameters;
  if (special) {
    parameters.insert(parameters.end(), special->parameters.begin(), special->parameters.end());
  }
  HiddenEffect hidden;
  hidden.name = request.name;
  hidden.on_noise = special && special->on_noise;
  hidden.channel = effect ? effect->channel() : Sensor::kMag;
  if (hidden.on_noise) hidden.channel = request.channel.value_or(Sensor::kMag);
  if (hidden.name == "linear_acceleration") hidden.channel = Sensor::kAcc;
  if (request.channel && *request.channel != hidden.channel) {
    refuse(fmt::format("{} is no effect on {}", request.name, to_string(*request.channel)),
           "leave the @ out: only noise_scale, correlated_noise and outliers take it");
  }
  const std::vector<double> values = request.numbers.empty()
                                         ? realistic_size(request, parameters, where)
                                         : checked(request, parameters, family);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    hidden.parameters.push_back({parameters[i].name, parameters[i].unit, values[i]});
  }
  check_range(hidden);
  return hidden;
}

std::shared_ptr<const Effect> term_of(const HiddenEffect& hidden) {
  const auto count = hidden.parameters.size();
  if (is_change(hidden.name)) {
    return make_change(hidden.name, forms_of_change(hidden.name).front(),
                       {.begin = {0, hidden[count - 2]}, .end = {0, hidden[count - 1]}});
  }
  if (hidden.name == "mains_interference") return make_mains_at(hidden[6]);
  // The clock is changed as a clock, all sensors alike.
  if (hidden.name == "clock_scale") return nullptr;
  if (const Special* special = find_special(hidden.name); special && special->replaces) {
    return nullptr;
  }
  const std::shared_ptr<const Effect> effect = find_effect(hidden.name);
  const auto family = of_size(*effect, count);
  return family ? family : effect;
}

VectorXd parameters_of(const HiddenEffect& hidden, const Effect& effect) {
  VectorXd theta(effect.size());
  for (int i = 0; i < effect.size(); ++i) theta[i] = hidden[std::size_t(i)];
  return theta;
}

}  // namespace magimu

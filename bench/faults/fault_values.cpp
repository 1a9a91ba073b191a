// SPDX-License-Identifier: BSD-3-Clause
// Single samples that no measurement has given: fault_kinds.h.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/faults/fault_kinds.h"

namespace magimu {
namespace {

const std::vector<std::string> kOutOfPlace = {"spike",
                                              "outlier",
                                              "jump",
                                              "impossible",
                                              "glitch",
                                              "isolated",
                                              "beyond",
                                              "out of range",
                                              "no measurement",
                                              "set aside",
                                              "left out",
                                              "too large",
                                              "implausible",
                                              "cannot be",
                                              "sentinel",
                                              "far from (its|both) neighbours",
                                              "wild"};

std::vector<std::string> and_also(std::vector<std::string> words,
                                  const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

void token_for(Damage& d, const std::vector<std::string>& tokens) {
  const int s = d.choose_sensor();
  const std::string token = d.dice.pick(tokens);
  const bool whole = d.dice.chance(0.5);
  const int axis = int(d.dice.index(3));
  for (const std::size_t r : d.few_rows(s)) {
    for (int i = 0; i < 3; ++i) {
      if (whole || i == axis) d.log.rows[r].tokens[3 * s + i] = token;
    }
  }
  d.what += "'" + token + "'";
}

void nan_token(Damage& d) {
  token_for(d, {"nan", "NaN", "NAN", "-nan", "null", "NA", "n/a", "-nan(ind)", "\"\""});
}
void inf_token(Damage& d) { token_for(d, {"inf", "-inf", "Infinity", "1e999", "1.#INF"}); }

// 7.3813 becomes 73813.
void lost_point(Damage& d) {
  const int s = d.choose_sensor(), axis = int(d.dice.index(3));
  for (const std::size_t r : d.few_rows(s, 1e-4, 2e-3)) {
    std::string text = fmt::format("{:.4f}", d.log.rows[r].v[std::size_t(s)][axis]);
    text.erase(text.find('.'), 1);
    d.log.rows[r].tokens[3 * s + axis] = text;
  }
}

void huge_value(Damage& d) {
  const int s = d.choose_sensor(), axis = int(d.dice.index(3));
  const double size = d.dice.sign() * d.dice.log_uniform(1e5, 1e20);
  for (const std::size_t r : d.few_rows(s, 1e-4, 2e-3))
    d.log.rows[r].v[std::size_t(s)][axis] = size;
  d.what += fmt::format("{:.3g}", size);
}

// Within what the sensor could read, but not there.
void spike(Damage& d) {
  const int s = d.choose_sensor();
  const double size = d.largest(s) * d.dice.log_uniform(0.3, 30.0);
  for (const std::size_t r : d.few_rows(s, 1e-4, 5e-3)) {
    d.log.rows[r].v[std::size_t(s)][int(d.dice.index(3))] += d.dice.sign() * size;
  }
  d.what += fmt::format("by {:.3g}", size);
}

// What a driver writes where it has no value: the most negative count, -4096, 655.35, 9999.
void sentinel(Damage& d) {
  const int s = d.choose_sensor();
  const double most = d.largest(s);
  const double value = d.dice.pick<double>(
      {-1.25 * most, 2.0 * most, -7.5 * most, -4096.0, -32768.0, 655.35, 9999.0, -1.0});
  const bool whole = d.dice.chance(0.3);
  const int axis = int(d.dice.index(3));
  for (const std::size_t r : d.some_rows(s, d.dice.log_uniform(0.001, 0.05))) {
    Vector3& v = d.log.rows[r].v[std::size_t(s)];
    for (int i = 0; i < 3; ++i) v[i] = whole || i == axis ? value : v[i];
  }
  d.what += fmt::format("{:.5g}{}", value, whole ? " in all axes" : "");
}

void zero_samples(Damage& d) {
  const int s = d.choose_sensor();
  for (const std::size_t r : d.some_rows(s, d.dice.log_uniform(0.001, 0.1))) {
    d.log.rows[r].v[std::size_t(s)].setZero();
  }
}

void zero_rows(Damage& d) {
  for (const std::size_t r : d.some_rows(0, d.dice.log_uniform(0.001, 0.05))) {
    for (Vector3& v : d.log.rows[r].v) v.setZero();
  }
}

// Counts of 16 bits and a range that is passed by: readings come out on the other side.
void int16_wrap(Damage& d) {
  const int s = d.choose_sensor();
  const double range = d.largest(s) * d.dice.uniform(0.6, 0.97), lsb = range / 32768.0;
  int wrapped = 0;
  for (const std::size_t r : d.log.rows_of(s)) {
    for (double& x : d.log.rows[r].v[std::size_t(s)]) {
      const double counts = std::round(x / lsb);
      const double inside = counts - 65536.0 * std::floor((counts + 32768.0) / 65536.0);
      wrapped += inside != counts;
      x = lsb * inside;
    }
  }
  d.what += fmt::format("{} values beyond {:.4g}", wrapped, range);
}

void clipping(Damage& d) {
  const int s = d.choose_sensor();
  const double range = d.largest(s) * d.dice.uniform(0.4, 0.97);
  for (const std::size_t r : d.log.rows_of(s)) {
    Vector3& v = d.log.rows[r].v[std::size_t(s)];
    v = v.cwiseMin(range).cwiseMax(-range);
  }
  d.what += fmt::format("at {:.4g}", range);
}

// One of the upper bits of a 16-bit count, wrong for one sample.
void bit_flip(Damage& d) {
  const int s = d.choose_sensor(), axis = int(d.dice.index(3));
  const double full = d.largest(s) * d.dice.uniform(1.0, 4.0);
  const double step = full / double(1 << (1 + d.dice.index(5)));
  for (const std::size_t r : d.few_rows(s, 1e-4, 5e-3)) {
    d.log.rows[r].v[std::size_t(s)][axis] += d.dice.sign() * step;
  }
  d.what += fmt::format("by {:.4g}", step);
}

void swapped_bytes(Damage& d) {
  const int s = d.choose_sensor();
  const double lsb = d.largest(s) * 1.5 / 32768.0;
  for (const std::size_t r : d.few_rows(s, 1e-4, 2e-3)) {
    for (double& x : d.log.rows[r].v[std::size_t(s)]) {
      const auto counts = std::uint16_t(std::int16_t(std::lround(x / lsb)));
      x = lsb * std::int16_t(std::uint16_t(counts << 8 | counts >> 8));
    }
  }
}

// A transfer that failed: any counts within the range, on all axes of a sensor at once.
void garble(Damage& d, int s, double full, std::size_t row) {
  for (double& x : d.log.rows[row].v[std::size_t(s)]) x = full * d.dice.uniform(-1.0, 1.0);
}

void garbage(Damage& d) {
  const int s = d.choose_sensor();
  const double full = d.largest(s) * d.dice.log_uniform(1.0, 10.0);
  for (const std::size_t r : d.few_rows(s, 1e-4, 2e-2)) garble(d, s, full, r);
  d.what += fmt::format("within {:.4g}", full);
}

// The same for all sensors that the transfer is of.
void garbage_rows(Damage& d) {
  const double times = d.dice.log_uniform(1.0, 10.0);
  for (const std::size_t r : d.few_rows(0, 1e-4, 2e-2)) {
    for (int s = 0; s < int(d.log.rows[r].v.size()); ++s) {
      if (d.log.rows[r].v[std::size_t(s)].allFinite()) garble(d, s, times * d.largest(s), r);
    }
  }
  d.what += fmt::format("within {:.3g} times the largest", times);
}

}  // namespace

void add_value_faults(std::vector<FaultKind>& kinds) {
  const std::vector<std::string> not_finite = and_also(
      {"nan", "not finite", "not a (finite )?number", "infinit", "\\binf\\b"}, kOutOfPlace);
  const std::vector<std::string> zeros = and_also({"zero", "exactly 0", "0, 0, 0"}, kOutOfPlace);
  kinds.insert(
      kinds.end(),
      {{.name = "nan_token", .words = not_finite, .info_can_see = true, .apply = nan_token},
       {.name = "inf_token", .words = not_finite, .info_can_see = true, .apply = inf_token},
       {.name = "lost_point",
        .words = kOutOfPlace,
        .of_sensor = true,
        .info_can_see = true,
        .apply = lost_point},
       {.name = "huge_value",
        .words = kOutOfPlace,
        .of_sensor = true,
        .info_can_see = true,
        .apply = huge_value},
       {.name = "spike",
        .words = kOutOfPlace,
        .of_sensor = true,
        .info_can_see = true,
        .apply = spike},
       {.name = "sentinel",
        .words = and_also(kOutOfPlace, {"same value", "repeat"}),
        .of_sensor = true,
        .info_can_see = true,
        .apply = sentinel},
       {.name = "zero_samples",
        .words = zeros,
        .of_sensor = true,
        .info_can_see = true,
        .apply = zero_samples},
       {.name = "zero_rows", .words = zeros, .info_can_see = true, .apply = zero_rows},
       {.name = "int16_wrap",
        .words = and_also(kOutOfPlace, {"wrap", "overflow", "converter", "full scale"}),
        .of_sensor = true,
        .info_can_see = true,
        .apply = int16_wrap},
       {.name = "clipping",
        .words = {"clip", "saturat", "full scale", "extreme value", "range"},
        .of_sensor = true,
        .info_can_see = true,
        .apply = clipping},
       {.name = "bit_flip",
        .words = kOutOfPlace,
        .of_sensor = true,
        .info_can_see = true,
        .apply = bit_flip},
       {.name = "swapped_bytes",
        .words = kOutOfPlace,
        .of_sensor = true,
        .info_can_see = true,
        .apply = swapped_bytes},
       {.name = "garbage",
        .words = kOutOfPlace,
        .of_sensor = true,
        .info_can_see = true,
        .apply = garbage},
       {.name = "garbage_rows",
        .words = kOutOfPlace,
        .info_can_see = true,
        .apply = garbage_rows}});
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// What the checks of units (check_units() in quality.h) share: an issue that names the file's unit
// and the option that gives it, the units and sensitivities that readings may be in, and the
// stretches in which an accelerometer reads gravity. Internal to recording/checks.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "recording/checks/quality_checks.h"
#include "recording/data/recording.h"

namespace magimu {

// Within this part of it a number is the factor, unit or sensitivity that is meant.
inline constexpr double kNear = 0.05;
inline constexpr double kScaleSigmas = 5.0;    // standard errors by which a scale is off
inline constexpr double kLeastCounts = 200.0;  // a g: the coarsest converter has 256

// Unit in which the file gave this quantity ("acc", "gyr", "mag"), in ours.
double file_unit(const Recording& r, const std::string& quantity);

// What a caller of the library does to readings in memory that are in another unit than was
// thought.
std::string scaled_in_memory(const std::string& quantity, double factor);

// A fatal issue. quantity: "acc", "gyr", "mag", in which the sensor's unit was given; unit: as
// --unit takes it, or several, each with its meaning.
Issue unit_issue(const Recording& r, const std::string& sensor, const std::string& quantity,
                 const std::string& problem, const std::string& unit);

// The name that --unit has for a unit of about this size in ours, or the number.
std::string unit_text(const std::string& quantity, double in_ours, double near = kNear);

// Whether all numbers in the file are whole, as counts of a converter are.
bool is_whole(const VectorSeries& s, double file_unit);

// Of some sensitivities (counts a unit) the nearest one, on a logarithmic scale.
template <std::size_t N>
double nearest(const double (&known)[N], double counts) {
  return *std::ranges::min_element(known, {},
                                   [&](double k) { return std::abs(std::log(counts / k)); });
}

// The nearest of them where it is near enough to be meant, else the number itself.
template <std::size_t N>
double snapped(const double (&known)[N], double counts, double same) {
  const double best = nearest(known, counts);
  return std::abs(counts / best - 1.0) < same ? best : counts;
}

// What is read in the stretches that scatter least.
struct Quietest {
  double length = 0.0;   // of their means; the median of them
  bool at_rest = false;  // whether they are rests: what is read there hardly scatters
};
Quietest quietest_of(const VectorSeries& s);

// The checks of one sensor each; empty where its unit is right, or cannot be told.
std::vector<Issue> check_acc_unit(const Recording& r);
// In many attitudes gravity has one length, whatever the bias: whether the accelerometer's scale is
// wrong by more than places differ.
std::vector<Issue> check_acc_scale(const Recording& r);
std::vector<Issue> check_gyr_unit(const Recording& r);
std::vector<Issue> check_mag_unit(const Recording& r, const std::string& name,
                                  const VectorSeries& mag);

}  // namespace magimu

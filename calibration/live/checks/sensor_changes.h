// SPDX-License-Identifier: BSD-3-Clause
// Has a sensor begun to read otherwise than before, while the samples arrive? For stretches of 1,
// 2, 4, ... 32 windows the estimator says what the stretch alone, given all before it, makes of
// another bias of each sensor in it (solvers/tree/stretch.h): z = b + n, n normal with the
// stretch's covariance C. As long as the model holds, those of one length that do not overlap are
// independent of each other and b = 0. Long stretches see what turns the attitude slowly, short
// ones what comes and goes. Real noise is coloured and has tails: n has a part of a size v of its
// own, one of a few, and one stretch in a hundred has an error of any size.
//
// Beside "as before" stand, for every stretch in which it may have begun, two kinds in four sizes
// s, in units of what one stretch tells:
//
//   stays   b is normal with s at first and wanders by s / 4 from one to the next: a step, a drift
//   fresh   b is drawn anew in each, with s: a gain that changed, a field that varies
//
// Their evidence against "as before" since then is weighed by a beginning in one window of a
// hundred, and shared by lengths and sensors. Under "as before" that ratio is on average not above
// what was put in, so that it passes odds of 100, which is when it is told, in at most T / 100 /
// 100 of streams of T windows (Doob's inequality).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "graph/scalar.h"
#include "solvers/tree/stretch.h"

namespace magimu {

struct SensorChange {
  int sensor = -1;  // 0: accelerometer, 1: gyroscope, 2 and on: magnetometers; -1: nothing yet
  std::vector<int> also_likely;  // other sensors that are nearly as likely
  double since_s = 0.0, earliest_s = 0.0,
         latest_s =
             0.0;  // s: the most probable time; in nine of ten cases it is between the other two
  bool stays = true;
  Vector3 size = Vector3::Zero();  // of its bias by now (stays), else root mean square in each axis
  double log_odds = -1e300;        // log odds of a change against none

  bool is_told() const;
  // Whether a change is more likely than none, and far more likely than one of any other sensor.
  bool clearly() const { return sensor >= 0 && log_odds > 0.0 && also_likely.empty(); }
  void save(ByteWriter& out) const;
  void load(ByteReader& in);
};
// Which sensor, since when, and by how much; names: of the magnetometers.
std::string sentence(const SensorChange& d, const std::vector<std::string>& mag_names);
// What to do, in one or two sentences.
std::string advice(const SensorChange& d);

// Not thread safe.
class SensorChanges {
 public:
  // Adds a window as it stands against all windows before it. `biases`: columns of the sensors'
  // biases among the globals, in the order of SensorChange::sensor. Windows must come in order of
  // time. One that does not begin where the last one ended begins a new stretch.
  void add(Stretch window, const std::vector<GlobalColumns>& biases, double begin_s, double end_s);
  // The likeliest change, whatever its odds are.
  SensorChange likeliest() const;
  void forget();

  void save(ByteWriter& out) const;
  void load(ByteReader& in);

 private:
  static constexpr int kLengths = 6, kScatters = 4, kSizes = 4;
  static constexpr double kLost = -1e300;  // of a scatter that is far too unlikely to be followed
  // b as far as the readings since it began tell it, if all have the scatter v; log: the readings'
  // density, of all since the stream's begin.
  struct State {
    std::array<double, 3> mean{};
    std::array<double, 9> covariance{};
    double log = 0.0;
    bool lost() const { return log <= kLost; }
  };
  using States = std::array<State, kScatters>;
  struct Hypothesis {
    States states;
    double size = 0.0;  // s
    bool stays = true;
  };
  // All that began in one stretch, or in one of a few that are told apart no longer.
  struct Beginning {
    double begin_s = 0.0, end_s = 0.0;
    double windows = 1.0;
    double log_weight = 0.0;  // against "as before"
    std::array<Hypothesis, 2 * kSizes> hypotheses;
  };
  struct Watched {
    double unit = 0.0;  // what one stretch tells; 0: nothing yet
    States as_before;
    std::vector<Beginning> beginnings;
    double log_odds() const;
  };
  struct Reading {
    Reading(const Vector3& z, const Matrix3& C, double unit);
    double log_density(int v, const Vector3& mean, const Matrix3& P,
                       Eigen::LLT<Matrix3>& of_b) const;
    double with_any_error(int v, double own) const;

    Vector3 z;
    std::array<Matrix3, kScatters> C;  // with each scatter
    std::array<double, kScatters> any_error;
  };
  // Stretches of one length begin every half of it: two series, each without overlap.
  struct Length {
    std::optional<Stretch> last;  // of the first series
    double begin_s = 0.0, end_s = 0.0;
    long joined = 0;                             // of them, to longer ones
    std::array<std::vector<Watched>, 2> series;  // one a sensor
  };
  static void take_in(const Reading& reading, int v, State& state);
  static double log_density(const States& states);
  static void take_in(const Reading& reading, double largest, Watched& w, double begin_s,
                      double end_s, int windows);
  static void prune(std::vector<Beginning>& beginnings);
  void add(Stretch stretch, const std::vector<GlobalColumns>& biases, double begin_s, double end_s,
           int length, int series);
  int sensors() const;
  double log_odds(int sensor) const;

  std::array<Length, kLengths> lengths_;
};

}  // namespace magimu

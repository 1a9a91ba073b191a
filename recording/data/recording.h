// SPDX-License-Identifier: BSD-3-Clause
// A recording of one device: every sensor with a time base of its own, because magnetometers are
// often slower than the IMU and never quite in step with it. Units and frames are those of
// docs/theory.md: s, m/s^2, rad/s, uT; all vectors in the sensor's own axes.
#pragma once

#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "graph/rot3.h"
#include "graph/sensor.h"

namespace magimu {

// Samples of a vector-valued sensor; t is increasing, in seconds.
struct VectorSeries {
  std::vector<double> t;
  std::vector<Vector3> v;

  std::size_t size() const { return t.size(); }
  bool empty() const { return t.empty(); }
  // One sample more; its time is after the last one's.
  void push_back(double time, const Vector3& value) {
    t.push_back(time);
    v.push_back(value);
  }
  // Samples a second: the reciprocal of the median interval; 0 with fewer than two samples.
  double rate_hz() const;
};

// Without the samples that equal the one before in every bit: a sensor with a slower clock of its
// own is often read more often than it measures. Of what is read first after a gap nobody knows how
// old it is: it is left out, too.
VectorSeries without_repeats(const VectorSeries& series);

// The same, sample by sample.
class NewReadings {
 public:
  // s between readings, as a rule.
  explicit NewReadings(double usual_s) : usual_s_(usual_s) {}
  // Whether this one, later than the last, was measured since then.
  bool operator()(double t, const Vector3& v);

 private:
  double usual_s_;
  double last_t_ = -std::numeric_limits<double>::infinity();
  Vector3 last_v_ = Vector3::Zero();
};

struct ScalarSeries {
  std::vector<double> t;
  std::vector<double> v;
};

// What cameras or a simulator know of the motion: for judging results, never for estimating them.
struct MotionTruth {
  std::vector<double> t;
  std::vector<Rot3> nRb;          // sensor to a fixed frame; not necessarily our frame n
  std::vector<Vector3> position;  // m, in that frame; empty if unknown
  std::vector<bool> valid;        // false where the cameras lost the markers: nRb is then the
                                  // identity and position what the file has, NaN as a rule
  std::vector<bool> moving;       // the phase that counts in a benchmark; empty if unknown
};

// Samples of one sensor that no measurement can have given, taken out before anything else looks at
// the recording (gate.h). What they leave is a gap of that sensor alone.
struct SetAside {
  std::string sensor;  // "acc", "gyr", "mag", "mag2", ...
  // "not_finite", "range", "spike", "stuck", "zeros", "sentinel", "wrap", "clipped", "disturbed",
  // "dead_zone"
  std::string kind;
  std::size_t count = 0, of = 0;      // samples taken out, and samples the sensor had
  double begin_s = 0.0, end_s = 0.0;  // times of the first and the last of them
  std::string example;                // the first of them: "acc_x = 98000 m/s^2 at 12.34 s"
};

struct Recording {
  std::string name;                         // for messages: the file's name
  VectorSeries acc;                         // specific force, m/s^2
  VectorSeries gyr;                         // mean rate over [t_k, t_k+1), rad/s
  std::vector<VectorSeries> mag;            // one entry a magnetometer, uT
  std::vector<std::string> mag_names;       // "mag", or "mag1", "mag2", ...
  std::map<std::string, ScalarSeries> aux;  // "temp" K or deg C, "current" A
  std::optional<VectorSeries> pos;          // m, where a file has pos_x..z
  std::optional<MotionTruth> truth;
  std::vector<std::string> notes;  // what the reader did, in words: column mapping, ...
  // Those of them that every result repeats as a warning: times that were mended, samples dropped.
  std::vector<std::string> cautions;
  // One unit of the file in ours, by quantity ("t", "acc", "gyr", "mag"), as the header or the user
  // gave it; 1 where absent. For advice: the unit that was given is not asked for again.
  std::map<std::string, double> file_units;
  std::vector<SetAside> set_aside;
  // A later part of the recording before it, after a gap or a reset of the clock: the device and
  // the field are the same, the attitude at its start is not known.
  bool continues_previous = false;

  // Seconds from the first to the last IMU sample.
  double duration_s() const;
};

// Of an array: the first magnetometer's.
const VectorSeries& series_of(const Recording& recording, Sensor sensor);
VectorSeries& series_of(Recording& recording, Sensor sensor);

// Which interval the rate of a gyroscope sample at t_k is the mean over.
enum class GyroInterval {
  kForward,   // [t_k, t_k+1): what Recording holds
  kCentred,   // half a sample to each side
  kBackward,  // [t_k-1, t_k)
};

// Moves the gyroscope's time base so that samples which follow `convention` are as Recording holds
// them.
void convert_gyro_interval(Recording& recording, GyroInterval convention);

// The part t0 <= t < t1 of every series, truth included; times stay as they are.
Recording slice(const Recording& recording, double t0, double t1);

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// Calibration while the sensor is being turned: samples go in as they arrive, and at the end of
// every window (a second) an update comes out with the estimate so far, how sure it is, whether the
// window fits the rest, and what the person who holds the sensor should do next.
//
//   StreamingCalibration stream(1, options);
//   for (const StreamSample& sample : source)
//     if (const auto update = stream.add(sample)) print(*update);
//   const Calibration calibration = stream.finish();
//
// Everything is a function of the samples added, in their order: the same samples give the same
// bits. A checkpoint therefore is the samples themselves (recording/sample_journal.h).
#pragma once

#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibration/calibration.h"
#include "graph/bytes.h"
#include "recording/stream_sample.h"

namespace magimu {

class IncrementalQr;

// When the estimate is good enough: every limit that is given must be met.
struct StreamTarget {
  std::optional<double> heading_deg;  // standard deviation of the heading that D and o_m give
  std::optional<double> mag_bias_uT;  // of o_m, the largest of its three
  std::optional<double> acc_bias;     // m/s^2, likewise
  std::optional<double> gyr_bias;     // rad/s, likewise
};

struct StreamingOptions {
  double window_s = 1.0;
  std::optional<NoiseDensities> noise;  // given, or found in rests and residuals
  double gravity = kStandardGravity;    // m/s^2
  MotionModel motion = MotionModel::kAuto;
  StreamTarget target;  // empty: heading 0.5 deg
  // From so many nodes on (20 minutes at 12 a second) finish() takes the estimator's own solution
  // (calibration/stream_long.cpp); below, it fits all samples at once, which needs some 20 kB a
  // node.
  int long_stream = 15000;
  // Windows, the newest, that keep all that they are made of, 300 kB each; old ones keep 12 kB. The
  // estimate does not depend on it.
  int awake = 256;
};

enum class StreamPhase { kCollecting, kCalibrating, kConverged };
std::string to_string(StreamPhase phase);

// One window's consistency with all others.
struct WindowFit {
  double nis = 0.0;  // normalized innovation squared
  int dof = 0;
  double p_value = 1.0;
  bool used = true;
};

struct StreamUpdate {
  double t = 0.0;    // of the window's last sample
  long samples = 0;  // added so far
  StreamPhase phase = StreamPhase::kCollecting;
  // The estimate so far, in order and units of Calibration: parameters, order, covariance,
  // covariance_model, strength, fields, trust; empty while collecting.
  std::optional<Calibration> theta;
  WindowFit window;
  std::string guidance;              // one sentence for the person who holds the sensor
  std::vector<std::string> missing;  // motions that are still missing, "turn about x"
  std::vector<std::string> events;   // sentences: a window excluded, a magnet attached at 12.3 s
  std::vector<Check> checks;         // of the stream so far: diagnostics.h
  std::vector<int> flagged_windows;  // all windows excluded at present
};

class StreamingCalibration {
 public:
  explicit StreamingCalibration(int magnetometers, const StreamingOptions& options = {});
  ~StreamingCalibration();
  StreamingCalibration(StreamingCalibration&&) noexcept;
  StreamingCalibration& operator=(StreamingCalibration&&) noexcept;

  // An update where this sample completes a window. Throws InputError where time does not increase
  // or the number of magnetometers differs. After a gap of more than 5 s, in which the sensor may
  // have turned anyhow, the estimate begins anew; finish() returns the better of the two.
  std::optional<StreamUpdate> add(const StreamSample& sample);
  // The calibration at the end, with the window that is not full and idle updates until old windows
  // are linearized well. Samples may be added after it.
  Calibration finish();
  // The estimate, so that another stream goes on from here with the same bits (take_up()); the
  // samples are not in it. False, and what was written is of no use: there is nothing that would
  // save time yet, or it cannot be kept.
  bool save(std::ostream& to) const;
  // A new stream that goes on from what save() has written. next: the samples of that stream, from
  // the first on, and nothing at the end; those that the estimate has are taken, no more. False: it
  // is damaged or of other samples, and this stream is of no use any more; begin anew without it.
  bool take_up(std::istream& from, const std::function<std::optional<StreamSample>()>& next);
  // Time of the last sample; not a number before the first.
  double last_t() const;

  // The estimate as it stands, as in updates; nothing while collecting.
  std::optional<Calibration> estimate() const;
  // Linearizes again what has drifted, as finish() does first.
  void settle();
  // Begin and end of each window since the last long gap, s; flagged_windows count through these.
  std::vector<std::pair<double, double>> windows() const;
  // Behind it all, for those who want the graph or the trajectory; null while collecting.
  const IncrementalQr* estimator() const;

 private:
  class State;
  void begin_anew(const std::string& why);
  void given_of(const StreamSample& sample);

  int magnetometers_;
  StreamingOptions options_;
  std::unique_ptr<State> state_;
  // Of the stream before its last long gap: the best calibration, samples, and what to say of it.
  std::optional<Calibration> before_;
  long samples_before_ = 0;
  Checksum given_;  // of all samples
  std::vector<std::string> events_;
};

}  // namespace magimu

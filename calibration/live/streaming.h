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
// bits. A checkpoint therefore is the samples themselves (recording/live/sample_journal.h).
#pragma once

#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibration/calibrate.h"
#include "calibration/live/checks/sensor_changes.h"
#include "calibration/result/calibration.h"
#include "graph/bytes.h"
#include "recording/data/stream_sample.h"

namespace magimu {

class FactorGraph;
class IncrementalQr;

// When the estimate is good enough: every limit that is given must be met.
struct StreamTarget {
  std::optional<double> heading_deg;  // standard deviation of the heading that D and o_m give
  std::optional<double> mag_bias_uT;  // of o_m, the largest of its three
  std::optional<double> acc_bias;     // m/s^2, likewise
  std::optional<double> gyr_bias;     // rad/s, likewise
};

struct StreamingOptions {
  double window_s = 1.0;                // length of a window, s
  std::optional<NoiseDensities> noise;  // given, or found in rests and residuals
  double gravity = kStandardGravity;    // m/s^2
  MotionModel motion = MotionModel::kAuto;
  StreamTarget target;  // empty: heading 0.5 deg
  // As in CalibrationOptions: the dip to start from, rad; the sign of the true one; what is known
  // beforehand.
  std::optional<double> dip_rad;
  int dip_sign = 0;
  std::function<void(FactorGraph&)> also = {};
  // For the calibration at the end, as there.
  PriorKind prior = PriorKind::kUsual;
  std::shared_ptr<const GivenPrior> given_prior = {};
  // A fault of the samples that explains why the magnetometer does not fit the rest between these
  // times, s, in a sentence (live_checks.h); empty: none is known.
  std::function<std::string(double begin_s, double end_s)> known_fault = {};
  // s: a stream up to this length keeps its samples as they came, and finish() is calibrate() of
  // them.
  double kept_s = 1200.0;
  // From so many nodes on (20 minutes at 12 a second) finish() takes the estimator's own solution
  // (calibration/live/stream_long.cpp); below, it fits all samples at once, which needs some 20 kB
  // a node.
  int long_stream = 15000;
  // Number of newest windows that keep their factors, 300 kB each; older ones keep 12 kB. The
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
  std::string guidance;              // for the person who holds the sensor, one or two sentences
  std::string headline;              // the same in two or three words: "Turn about X"
  int axis = -1;                     // to be turned about: 0, 1, 2; -1: none of these
  std::vector<std::string> missing;  // motions that are still missing, "turn about x"
  std::vector<std::string> events;   // sentences: a window excluded, a magnet attached at 12.3 s
  std::vector<Check> checks;         // of the stream so far: diagnostics.h
  std::vector<int> flagged_windows;  // all windows excluded at present
  // A sensor whose readings have changed, as long as the odds for that are high enough.
  std::optional<SensorChange> sensor_change;
};

class StreamingCalibration {
 public:
  explicit StreamingCalibration(int magnetometers, const StreamingOptions& options = {});
  ~StreamingCalibration();
  StreamingCalibration(StreamingCalibration&&) noexcept;
  StreamingCalibration& operator=(StreamingCalibration&&) noexcept;

  // An update where this sample completes a window. Throws InputError where time does not increase
  // for a sensor or the number of magnetometers differs. Samples that no measurement can have given
  // are set aside (recording/live/live_gate.h); after a gap too long to be bridged
  // (recording/data/parts.h) a part begins, with an attitude of its own and the same calibration.
  std::optional<StreamUpdate> add(const StreamSample& sample);
  // The calibration at the end: that of calibrate(), unless samples were left out or there are too
  // many to keep; then the stream's own, old windows linearized well. Samples may be added after
  // it.
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
  // Relinearizes windows whose linearization has drifted, as finish() does first.
  void settle();
  // Begin and end of each window, s; flagged_windows count through these.
  std::vector<std::pair<double, double>> windows() const;
  // The estimator, for callers that want its graph or trajectory; null while collecting. Owned by
  // the stream.
  const IncrementalQr* estimator() const;

 private:
  class State;
  void given_of(const StreamSample& sample);

  std::unique_ptr<State> state_;
  Checksum given_;  // of all samples
};

}  // namespace magimu

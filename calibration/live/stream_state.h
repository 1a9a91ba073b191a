// SPDX-License-Identifier: BSD-3-Clause
// What is behind StreamingCalibration: samples, the fit of all windows that a stream begins with
// (and repeats while it is short), the estimator that carries on from there, and what is said about
// it.
#pragma once

#include <deque>
#include <map>

#include "calibration/calibrate.h"
#include "calibration/live/guidance.h"
#include "calibration/live/stream_checks.h"
#include "calibration/live/stream_estimate.h"
#include "calibration/live/stream_maker.h"
#include "calibration/live/stream_model.h"
#include "calibration/live/streaming.h"
#include "calibration/live/window_consistency.h"
#include "calibration/pipeline.h"
#include "solvers/tree/incremental_qr.h"

namespace magimu {

class StreamingCalibration::State {
 public:
  State(int magnetometers, const StreamingOptions& options);

  std::optional<StreamUpdate> add(const StreamSample& sample);
  // A sample whose windows the estimator has, or will have from load().
  void add_known(const StreamSample& sample) { samples_.add(sample); }
  // stream_snapshot.cpp
  bool can_be_taken_up() const;
  bool save(ByteWriter& out) const;
  void load(ByteReader& in);
  Calibration finish();
  Calibration finish_as_asked();
  void settle();
  double last_t() const { return samples_.last_t(); }
  long samples() const { return samples_.count(); }
  const IncrementalQr* estimator() const { return estimator_ ? &*estimator_ : nullptr; }
  std::optional<Calibration> estimate() const;
  std::vector<std::pair<double, double>> windows() const;

 private:
  // stream_state.cpp
  void look_at_turning(const StreamSample& sample);
  void look_at_field();
  bool time_to_try() const;
  Vector3 upward() const;
  StreamUpdate collecting_update();
  StreamUpdate update();
  double distance(const Calibration& c) const;
  static int last_refit();
  int windows_done() const { return estimator_ ? estimator_->windows() : 0; }
  double begin_of(int window) const;
  double end_of(int window) const;

  void describe_stream(Calibration& c, const std::vector<const Recording*>& recordings) const;

  // stream_long.cpp
  Calibration finish_long();
  void integrate_again();
  Result settle_at_end();
  std::vector<StreamWindow> spans(int windows, int at_a_time) const;
  SensorSums look_at_residuals(const VectorXd& sigma, Calibration& c,
                               std::vector<double>& mag_squares) const;
  MatrixXd robust_covariance(const MatrixXd& P) const;

  // stream_fit.cpp
  void try_to_start();
  bool fit_all_windows();
  bool fit_from_blind_start(const std::vector<const Recording*>& recordings,
                            const std::vector<NodePlan>& plans, std::optional<Stage>& stage) const;
  bool fit_from_estimate(const std::vector<const Recording*>& recordings,
                         const std::vector<NodePlan>& plans, std::optional<Stage>& stage) const;
  bool take_over_fit(const std::vector<const Recording*>& recordings, const Stage& stage);
  IncrementalQr rebuilt(const Values& values, std::shared_ptr<StreamMaker>& maker) const;

  // stream_windows.cpp
  bool turned(int window) const;
  bool take_windows();
  bool add_window(const StreamWindow& window);
  bool is_sane() const;
  void begin_anew();
  bool take_in(const StreamWindow& window);
  void judge_all_windows();
  void judge_again();
  std::vector<GlobalColumns> biases() const;
  void look_for_change();
  std::function<bool(int node)> left_out() const;
  std::function<int(int node)> earlier_bias(const std::vector<int>& changes) const;
  void say(const std::string& event) { events_.push_back(event); }

  // stream_finish.cpp
  CalibrationOptions final_options() const;
  Recording without_flagged(const Recording& raw) const;
  Calibration finish(const StreamParts& parts);
  Calibration calibrate_as_kept(const Recording& raw) const;
  std::optional<Calibration> calibrate_since_change(const Recording& raw) const;
  bool is_good_enough();

  // stream_news.cpp
  void tell_news();
  void tell_set_aside();
  void tell_breaks();
  void add_set_aside(Calibration& c) const;
  void tell_change();
  void forget_changes();
  void tell(const SensorChange& change);

  StreamingOptions options_;
  CalibrationOptions batch_;
  StreamSamples samples_;
  // Scatter of the first magnetometer's readings, which tells how far it has been turned.
  Vector3 mag_origin_ = Vector3::Zero(), mag_sum_ = Vector3::Zero();
  Matrix3 mag_squares_ = Matrix3::Zero();
  std::size_t mags_ = 0;
  std::deque<std::pair<double, Vector3>> felt_;  // by the accelerometer, lately
  Vector3 turned_ = Vector3::Zero();             // rad, about each axis, either way
  double last_gyr_t_ = 0.0, still_since_ = 0.0, longest_still_ = 0.0;  // s
  std::vector<std::string> undetermined_;      // by the last fit that was tried
  double next_update_ = 0.0, next_try_ = 0.0;  // s of stream time, while collecting

  ModelSpec spec_;
  std::optional<IncrementalQr> estimator_;
  std::shared_ptr<StreamMaker> maker_;  // of its old windows' factors
  Calibration last_fit_;     // of all windows there were then; without trajectory and values
  double last_fit_s_ = 0.0;  // how long the stream was
  int last_fit_windows_ = 0;

  // Does what calibrate() makes of the samples so far bear the target out? The length of the
  // stream, s, from which it is asked again, and why it did not.
  bool borne_out_ = false;
  double next_asked_ = 0.0;
  std::string not_yet_;

  StreamChecks on_the_way_;
  WindowConsistency consistency_;
  WindowFit window_fit_;
  std::vector<int> flagged_;    // windows left out at present
  std::size_t judge_next_ = 0;  // among those
  int flagged_in_a_row_ = 0;
  std::vector<int> changes_;  // windows in which the bias changed for good
  std::vector<std::string> events_, warnings_;
  std::map<std::pair<std::string, std::string>, std::size_t> told_set_aside_;  // sensor and kind
  std::size_t told_breaks_ = 0;
  SensorChanges sensor_changes_;
  std::optional<SensorChange> changed_;  // that was told and stands
  std::vector<int> told_changes_;        // sensors
};

}  // namespace magimu

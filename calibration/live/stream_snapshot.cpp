// SPDX-License-Identifier: BSD-3-Clause
// A stream's estimate as bytes, to go on from without going through all windows again. The samples
// stay elsewhere (recording/live/sample_journal.h). Taking up begins as the stream did, up to its
// last fit of all windows: noise, lag and model follow from those samples. Of the windows since
// then there are no estimates to be made: what they have led to is in the snapshot.
#include <stdexcept>

#include "calibration/live/stream_state.h"
#include "graph/bytes.h"

namespace magimu {
namespace {

constexpr std::uint32_t kSnapshotVersion = 2;  // another where anything that is written changes

}  // namespace

void StreamChecks::save(ByteWriter& out) const {
  out.put(std::uint64_t(moments_.size()));
  for (const Moment& m : moments_) {
    out.put(m.t);
    out.put(m.distance);
    out.put(m.theta);
    out.put(m.variance);
    for (const double x : {m.window.nis, m.window.p_value}) out.put(x);
    out.put(m.window.dof);
    out.put(m.window.used);
  }
}

void StreamChecks::load(ByteReader& in) {
  moments_.resize(std::min<std::uint64_t>(in.get<std::uint64_t>(), 10000));
  for (Moment& m : moments_) {
    in.get(m.t);
    in.get(m.distance);
    in.get(m.theta);
    in.get(m.variance);
    for (double* x : {&m.window.nis, &m.window.p_value}) in.get(*x);
    in.get(m.window.dof);
    in.get(m.window.used);
  }
}

// From the last fit of all windows on. One that began anew later on has had other fits than the
// first windows lead to.
bool StreamingCalibration::State::can_be_taken_up() const {
  return estimator_ && estimator_->windows() > last_refit() && last_fit_windows_ <= last_refit();
}

bool StreamingCalibration::State::save(ByteWriter& out) const {
  if (!can_be_taken_up()) return false;
  out.put(maker_->biases);
  out.put(maker_->ends);
  out.put(changes_);
  out.put(flagged_);
  out.put(std::uint64_t(judge_next_));
  out.put(flagged_in_a_row_);
  consistency_.save(out);
  on_the_way_.save(out);
  sensor_changes_.save(out);
  out.put(changed_.has_value());
  if (changed_) changed_->save(out);
  out.put(told_changes_);
  out.put(int(warnings_.size()));
  for (const std::string& w : warnings_) out.put(w);
  out.put(int(told_set_aside_.size()));
  for (const auto& [what, told] : told_set_aside_) {
    out.put(what.first);
    out.put(what.second);
    out.put(std::uint64_t(told));
  }
  out.put(std::uint64_t(told_breaks_));
  return estimator_->save(out);
}

void StreamingCalibration::State::load(ByteReader& in) {
  std::vector<StreamMaker::Biases> biases;
  in.get(biases);
  std::vector<double> ends;
  in.get(ends);
  in.get(changes_);
  in.get(flagged_);
  judge_next_ = std::size_t(in.get<std::uint64_t>());
  in.get(flagged_in_a_row_);
  consistency_.load(in);
  on_the_way_.load(in);
  sensor_changes_.load(in);
  if (in.get<bool>()) changed_.emplace().load(in);
  in.get(told_changes_);
  warnings_.clear();
  for (int n = in.get<int>(); n > 0; --n) {
    warnings_.emplace_back();
    in.get(warnings_.back());
  }
  for (int n = in.get<int>(); n > 0; --n) {
    const auto sensor = in.get<std::string>(), kind = in.get<std::string>();
    told_set_aside_[{sensor, kind}] = std::size_t(in.get<std::uint64_t>());
  }
  told_breaks_ = std::size_t(in.get<std::uint64_t>());
  const auto windows = samples_.windows().size();
  if (biases.size() != windows || ends.size() != windows * samples_.ends().size())
    throw std::runtime_error("other windows than the samples'");
  if (!changes_.empty()) spec_.earlier_bias = earlier_bias(changes_);
  maker_ = std::make_shared<StreamMaker>(samples_, spec_);
  maker_->biases = std::move(biases);
  maker_->ends = std::move(ends);
  // Those of the last window, as they were left.
  const StreamMaker::Biases& b = maker_->biases.back();
  spec_.gyr_bias = Vector3(b[0], b[1], b[2]);
  spec_.acc_bias = Vector3(b[3], b[4], b[5]);
  estimator_.emplace(estimator_options(maker_, options_.awake));
  estimator_->load(in);
  if (std::size_t(estimator_->windows()) != windows) {
    throw std::runtime_error("other windows than the samples'");
  }
}

bool StreamingCalibration::save(std::ostream& to) const {
  ByteWriter out(to);
  out.put(kSnapshotVersion);
  out.put(state_->samples());
  out.put(given_.value());
  if (!state_->save(out)) return false;
  return out.finish();
}

bool StreamingCalibration::take_up(std::istream& from,
                                   const std::function<std::optional<StreamSample>()>& next) {
  try {
    if (!is_whole(from)) return false;
    ByteReader in(from);
    if (in.get<std::uint32_t>() != kSnapshotVersion) return false;
    const auto samples = in.get<long>();
    const auto given = in.get<std::uint64_t>();
    while (!state_->can_be_taken_up()) {
      const std::optional<StreamSample> sample = next();
      if (!sample || state_->samples() >= samples) return false;
      add(*sample);
    }
    while (state_->samples() < samples) {
      const std::optional<StreamSample> sample = next();
      if (!sample) return false;
      given_of(*sample);
      state_->add_known(*sample);
    }
    if (given_.value() != given) return false;
    state_->load(in);
    return true;
  } catch (const std::runtime_error&) {
    return false;
  }
}

// What was given to this stream so far, as a checksum.
void StreamingCalibration::given_of(const StreamSample& sample) {
  const auto add = [this](double x) { given_.add(&x, sizeof x); };
  const auto add_sensor = [&](const std::optional<Vector3>& v) {
    for (int i = 0; i < 3; ++i) add(v ? (*v)[i] : 0.0);
    add(v ? 1.0 : 0.0);
  };
  add(sample.t);
  add_sensor(sample.acc);
  add_sensor(sample.gyr);
  for (const auto& m : sample.mag) add_sensor(m);
}

}  // namespace magimu

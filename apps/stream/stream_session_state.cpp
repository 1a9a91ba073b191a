// SPDX-License-Identifier: BSD-3-Clause
// A session that goes on from the state of an earlier one, and keeps its own.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <utility>

#include "apps/stream/stream_session.h"
#include "recording/data/times/row_times.h"

namespace magimu::apps {
namespace {

constexpr const char* kEstimate = ".estimate";  // behind the name of the state
constexpr long kKeptEvery = 16;  // the estimate is kept when it has so much more: a 16th

}  // namespace

// The estimate as it was kept, a little earlier; false: there is none, and nothing has been read.
bool StreamSession::take_up() {
  std::ifstream kept(options_.state + kEstimate, std::ios::binary);
  if (!kept) return false;
  const bool taken = estimator_->take_up(kept, [this] {
    std::optional<StreamSample> sample = journal_->replay();
    if (sample) know(*sample);
    return sample;
  });
  keep_at_ = std::max(kFirstKept, samples_ + samples_ / kKeptEvery);
  if (taken) return true;
  samples_ = 0;
  known_ = {};
  known_until_.reset();
  const JournalIdentity identity = *journal_identity(options_.state);
  journal_.reset();
  estimator_.reset();
  begin_estimator(identity.magnetometers);
  return false;
}

// Beside the samples, from time to time: what comes after it is little, whatever comes before. It
// may be lost or damaged, so that nobody waits for the disk; the samples are what counts.
void StreamSession::keep_estimate() {
  // (With magnetometers left out it would not be that of the state's samples.)
  const bool all_used = std::ranges::find(used_, 0) == used_.end();
  if (!journal_ || samples_ < keep_at_ || !all_used) return;
  keep_at_ = samples_ + samples_ / kKeptEvery;
  const std::string path = options_.state + kEstimate, next = path + ".new";
  std::ofstream out(next, std::ios::binary | std::ios::trunc);
  const bool kept = out && estimator_->save(out);
  out.close();
  std::error_code ignored;
  if (kept && out) {
    std::filesystem::rename(next, path, ignored);
  } else {
    std::filesystem::remove(next, ignored);
  }
}

void StreamSession::know(const StreamSample& sample) {
  ++samples_;
  thinned_.add(sample);
  known_.add(sample);
  known_until_ = std::max(known_until_.value_or(sample.t), sample.t);
}

// What the state file remembers goes through the estimator again, unseen.
void StreamSession::resume() {
  if (options_.state.empty()) return;
  const std::optional<JournalIdentity> identity = journal_identity(options_.state);
  if (!identity) return;
  begin_estimator(identity->magnetometers);
  const long known = journal_->samples();
  take_up();
  std::optional<StreamUpdate> last;
  while (const std::optional<StreamSample> sample = journal_->replay()) {
    if (auto update = estimator_->add(*sample)) last = std::move(update);
    know(*sample);
    if (samples_ % 1000 != 0) continue;
    for (StreamObserver* o : observers_) o->replaying(double(samples_) / double(known));
  }
  if (last) set_update(std::move(*last), 0.0);
  if (!known_until_) return;
  event(fmt::format("{} goes on after {} samples, up to {:.6g} s", options_.state, known,
                    *known_until_));
}

// With samples that the state has not. A device that was switched on again counts its time from
// zero: a new part of the same calibration.
void StreamSession::go_on() {
  goes_on_ = true;
  known_ = {};
  const std::vector<StreamSample> first = std::exchange(doubtful_, {});
  if (!first.empty() && first.front().t <= *known_until_) {
    clock_s_ = *known_until_ + kPartGap - first.front().t;
    event(fmt::format(
        "the clock of {} goes on at {:.6g} s where {} has samples up to {:.6g} s (the board was "
        "reset?): a new part begins, its times go on at {:.6g} s",
        status_.source, first.front().t, options_.state, *known_until_, *known_until_ + kPartGap));
  }
  for (const StreamSample& sample : first) use_new(sample);
}

}  // namespace magimu::apps

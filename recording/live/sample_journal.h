// SPDX-License-Identifier: BSD-3-Clause
// The memory of a stream that may be killed at any moment. Its estimate is a function of the
// samples in their order, so the samples are the state:
//
//   FILE.samples   every sample so far, binary, only ever appended to
//   FILE           a few lines of text, replaced whole at each commit: format, magnetometers, the
//                  options that the estimate depends on, and how much of FILE.samples is valid,
//                  with its checksum
//
//   SampleJournal journal("board.state", {1, "motion auto"});
//   while (const std::optional<StreamSample> sample = journal.replay()) estimator.add(*sample);
//   ... journal.append(sample); journal.commit();  // from here on it survives a kill -9
//
// What was appended after the last commit is dropped on the next start.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "recording/data/stream_sample.h"

namespace magimu {

// What a state can be continued with.
struct JournalIdentity {
  int magnetometers = 1;
  std::string options;  // one line, in any words
};

// The identity of the state in this file; nothing if there is none yet.
std::optional<JournalIdentity> journal_identity(const std::string& path);

// Not thread safe; one process at a time, others are refused.
class SampleJournal {
 public:
  // Opens the state, or begins one. InputError with the remedy where it is of another identity or
  // version, truncated, damaged or in use.
  SampleJournal(const std::string& path, const JournalIdentity& identity);
  ~SampleJournal();
  SampleJournal(const SampleJournal&) = delete;
  SampleJournal& operator=(const SampleJournal&) = delete;

  // InputError where the state is not of this identity: for a source whose magnetometers become
  // known later.
  void require(const JournalIdentity& identity) const;

  // The committed samples in their order, each once; then nothing. To be exhausted before append().
  std::optional<StreamSample> replay();

  void append(const StreamSample& sample);
  // All that was appended is on the disk when this returns.
  void commit();

  long samples() const;                  // committed
  std::optional<double> last_t() const;  // of the last committed sample

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace magimu

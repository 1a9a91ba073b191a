// SPDX-License-Identifier: BSD-3-Clause
// The journal on POSIX: append, fdatasync, then the header by rename.
#include "recording/live/sample_journal.h"

#include <fmt/format.h>

#include <boost/crc.hpp>
#include <filesystem>
#include <utility>

#include "recording/data/error.h"
#include "recording/files/atomic_file.h"
#include "recording/files/read_file.h"
#include "recording/live/journal_file.h"
#include "recording/live/journal_header.h"

namespace magimu {
namespace {

// A sample's bytes: t, then one bit a sensor that it has, then three numbers for each of these.
void encode(std::string& out, const StreamSample& sample) {
  const auto number = [&out](double value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  number(sample.t);
  const std::size_t mask = out.size(), sensors = 2 + sample.mag.size();
  out.append((sensors + 7) / 8, '\0');
  for (std::size_t i = 0; i < sensors; ++i) {
    const std::optional<Vector3>& v = i == 0 ? sample.acc : i == 1 ? sample.gyr : sample.mag[i - 2];
    if (!v) continue;
    out[mask + i / 8] = static_cast<char>(out[mask + i / 8] | (1 << (i % 8)));
    for (int axis = 0; axis < 3; ++axis) number((*v)[axis]);
  }
}

}  // namespace

class SampleJournal::State {
 public:
  State(const std::string& path, const JournalIdentity& identity)
      : path_(path), file_(path + ".samples") {
    if (!std::filesystem::exists(path)) {
      if (file_.size() > 0) {
        throw InputError(path, 0, 0, "is missing, but " + file_.path() + " is there",
                         "delete that one to begin anew, or give another --state");
      }
      header_.identity = identity;
      write_atomically(path_, journal_header_text(header_));
      return;
    }
    header_ = parse_journal_header(read_file(path), path);
    require(identity);
    check_content();
  }

  void require(const JournalIdentity& now) const {
    const JournalIdentity& then = header_.identity;
    if (then.magnetometers != now.magnetometers) {
      throw InputError(
          path_, 0, 0,
          fmt::format("is the state of a stream with {} magnetometers, this one has {}",
                      then.magnetometers, now.magnetometers),
          "give another --state for this device");
    }
    if (then.options != now.options) {
      throw InputError(path_, 0, 0,
                       fmt::format("was begun with other options ({}) than these ({})",
                                   then.options, now.options),
                       "give the same ones to go on, or another --state to begin anew");
    }
  }

  std::optional<StreamSample> replay() {
    if (replayed_ == header_.bytes) return std::nullopt;
    StreamSample sample;
    sample.t = number();
    const auto magnetometers = std::size_t(header_.identity.magnetometers);
    const std::string mask = bytes((2 + magnetometers + 7) / 8);
    sample.mag.resize(magnetometers);
    for (std::size_t i = 0; i < 2 + magnetometers; ++i) {
      if ((mask[i / 8] >> (i % 8) & 1) == 0) continue;
      std::optional<Vector3>& v = i == 0 ? sample.acc : i == 1 ? sample.gyr : sample.mag[i - 2];
      const double x = number(), y = number(), z = number();
      v = Vector3(x, y, z);
    }
    return sample;
  }

  void append(const StreamSample& sample) {
    encode(pending_, sample);
    ++pending_samples_;
    pending_t_ = sample.t;
  }

  void commit() {
    if (pending_.empty()) return;
    file_.append(header_.bytes, pending_);
    crc_.process_bytes(pending_.data(), pending_.size());
    header_.bytes += pending_.size();
    header_.samples += std::exchange(pending_samples_, 0);
    header_.last_t = pending_t_;
    header_.crc = crc_.checksum();
    pending_.clear();
    replayed_ = header_.bytes;
    write_atomically(path_, journal_header_text(header_));
  }

  const JournalHeader& header() const { return header_; }

 private:
  void check_content() {
    if (file_.size() < header_.bytes) {
      damaged(
          fmt::format("{} is cut off: {} bytes of {}", file_.path(), file_.size(), header_.bytes));
    }
    for (std::uint64_t at = 0; at < header_.bytes;) {
      const std::string block = file_.read(at, header_.bytes - at);
      crc_.process_bytes(block.data(), block.size());
      at += block.size();
    }
    if (crc_.checksum() != header_.crc) damaged(file_.path() + " is damaged: wrong checksum");
    file_.cut(header_.bytes);
  }

  [[noreturn]] void damaged(const std::string& problem) const {
    throw InputError(path_, 0, 0, problem,
                     fmt::format("delete {} and {} to begin anew, or give another --state", path_,
                                 file_.path()));
  }

  double number() {
    double value = 0.0;
    bytes(sizeof value).copy(reinterpret_cast<char*>(&value), sizeof value);
    return value;
  }

  std::string bytes(std::size_t count) {
    if (header_.bytes - replayed_ < count) damaged(file_.path() + " ends within a sample");
    if (block_.size() - in_block_ < count) {
      block_ = file_.read(replayed_, header_.bytes - replayed_);
      in_block_ = 0;
      if (block_.size() < count) damaged(file_.path() + " cannot be read whole");
    }
    replayed_ += count;
    in_block_ += count;
    return block_.substr(in_block_ - count, count);
  }

  std::string path_;
  JournalFile file_;
  JournalHeader header_;
  boost::crc_32_type crc_;
  std::uint64_t replayed_ = 0;  // bytes
  std::string block_;           // of the file, to replay from
  std::size_t in_block_ = 0;
  std::string pending_;
  long pending_samples_ = 0;
  double pending_t_ = 0.0;
};

std::optional<JournalIdentity> journal_identity(const std::string& path) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  return parse_journal_header(read_file(path), path).identity;
}

SampleJournal::SampleJournal(const std::string& path, const JournalIdentity& identity)
    : state_(std::make_unique<State>(path, identity)) {}
SampleJournal::~SampleJournal() = default;

void SampleJournal::require(const JournalIdentity& identity) const { state_->require(identity); }
std::optional<StreamSample> SampleJournal::replay() { return state_->replay(); }
void SampleJournal::append(const StreamSample& sample) { state_->append(sample); }
void SampleJournal::commit() { state_->commit(); }
long SampleJournal::samples() const { return state_->header().samples; }
std::optional<double> SampleJournal::last_t() const {
  if (samples() == 0) return std::nullopt;
  return state_->header().last_t;
}

}  // namespace magimu

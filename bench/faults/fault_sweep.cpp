// SPDX-License-Identifier: BSD-3-Clause
// Draws, damages, runs and judges: fault_sweep.h.
#include "bench/faults/fault_sweep.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace magimu {
namespace {

// Damaged versions made of one clean recording. The program's answers to the clean one are computed
// once for all of them.
constexpr int kDamagedOfOne = 4;
// One recording in twenty is left undamaged.
constexpr int kUndamagedEvery = 20;

class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "faults-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  const std::string& path() const { return path_; }
  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(path_ + '/' + name, std::ios::binary) << content;
    return name;
  }

 private:
  std::string path_;
};

// A recording before it is damaged, and what is said of it.
struct Clean {
  Base base;
  Verdicts verdicts;
  Sentences said;
};

double shift(const Verdicts& clean, const Verdicts& now) {
  if (clean.calibration.is_null()) return -1.0;
  if (now.calibration.is_null()) return std::numeric_limits<double>::infinity();
  const Distance d = distance(clean.calibration, now.calibration);
  return d.parameters > 0 ? d.worst_sigma : -1.0;
}

class Sweep {
 public:
  explicit Sweep(const SweepOptions& options) : options_(options) {}

  SweepRow run(int index) {
    const std::string name = kind_of(index, options_);
    const FaultKind* kind = find_kind(name);
    if (!kind && name != kNoFault) throw std::invalid_argument("no fault is called " + name);
    const Clean& clean = clean_for(index, kind && kind->needs_simulation);
    Dice dice(std::uint64_t(index), name);
    const Damage damage = kind ? damaged(clean.base, *kind, dice) : undamaged(clean.base, dice);
    const std::string text = file_text(damage.log);
    const Verdicts v = kind ? verdicts_of(text) : clean.verdicts;
    SweepRow row = about(clean.base, index, name);
    row.what = damage.what;
    if (kind) {
      row.info_can_see = kind->info_can_see;
      row.unnamed = kind->unnamed;
      const Named by = magimu::named(*kind, damage, sentences(v), clean.said);
      row.named = std::string(by.by_info ? "i" : "") + (by.by_calibrate ? "c" : "") +
                  (by.by_diagnose ? "d" : "");
      row.shift_sigma = shift(clean.verdicts, v);
    } else {
      row.shift_sigma = 0.0;
    }
    fill(row, clean.verdicts, v, damage);
    if (!options_.keep.empty() && (row.bad() || !options_.only.empty())) keep(row, text, clean);
    return row;
  }

 private:
  Verdicts verdicts_of(const std::string& text) {
    return run_commands(options_.program, folder_.path(), folder_.write("recording.csv", text),
                        options_.limits);
  }

  const Clean& clean_for(int index, bool simulated) {
    const std::uint64_t seed = std::uint64_t(index / kDamagedOfOne) + 1;
    if (clean_ && clean_->base.seed == seed && (!simulated || clean_->base.truth)) return *clean_;
    BaseWishes wishes;
    wishes.real = !simulated;
    wishes.small = options_.small;
    wishes.data_dir = options_.data_dir;
    clean_ = Clean{draw_base(seed, wishes), {}, {}};
    clean_->verdicts = verdicts_of(file_text(clean_->base.log));
    clean_->said = sentences(clean_->verdicts);
    return *clean_;
  }

  static SweepRow about(const Base& base, int index, const std::string& kind) {
    SweepRow row;
    row.index = index;
    row.kind = kind;
    row.source = base.source;
    row.motion = base.motion;
    row.rate_hz = base.rate_hz;
    row.duration_s = base.duration_s;
    row.magnetometers = base.magnetometers();
    row.rich = base.rich;
    return row;
  }

  static void fill(SweepRow& row, const Verdicts& clean, const Verdicts& v, const Damage& damage) {
    row.info_code = v.info.exit_code;
    row.calibrate_code = v.calibrate.exit_code;
    row.diagnose_code = v.diagnose.exit_code;
    for (const Ended* e : {&v.info, &v.calibrate, &v.diagnose}) {
      row.seconds = std::max(row.seconds, e->processor_s);
      row.memory_mb = std::max(row.memory_mb, e->resident_mb);
    }
    row.problem = v.problem();
    row.clean_trust = clean.trust();
    row.trust = v.trust();
    row.clean_answer = clean.answer();
    row.answer = v.answer();
    if (damage.truth && !v.calibration.is_null()) {
      const Distance d = distance(v.calibration, as_calibration(*damage.truth));
      row.truth_squared = d.squared;
      row.outside = d.outside();
    }
    row.info_permits = v.info_permits();
    row.contradiction = v.contradiction();
    row.findings = v.findings();
    row.reason = v.first_reason();
  }

  void keep(const SweepRow& row, const std::string& text, const Clean& clean) const {
    std::filesystem::create_directories(options_.keep);
    const std::string stem = fmt::format("{}/{}_{}", options_.keep, row.kind, row.index);
    std::ofstream(stem + ".csv", std::ios::binary) << text;
    std::ofstream(stem + ".undamaged.csv", std::ios::binary) << file_text(clean.base.log);
  }

  SweepOptions options_;
  Folder folder_;
  std::optional<Clean> clean_;
};

}  // namespace

bool SweepRow::bad() const {
  return !problem.empty() || !contradiction.empty() || false_hope() || (yes() && outside) ||
         (harmful() && named.empty());
}

std::vector<int> indices_of_part(const SweepOptions& o) {
  std::vector<int> list;
  const int from = int(std::int64_t(o.count) * (o.part - 1) / o.of);
  const int to = int(std::int64_t(o.count) * o.part / o.of);
  for (int i = from; i < to; ++i) list.push_back(o.first + i);
  return list;
}

std::string kind_of(int index, const SweepOptions& options) {
  if (!options.only.empty()) return options.only;
  if (index % kUndamagedEvery == 0) return kNoFault;
  // All kinds before any comes again; neighbours are of different families.
  const auto n = std::uint64_t(fault_kinds().size());
  std::uint64_t step = n / 3 + 1;
  while (std::gcd(step, n) != 1) ++step;
  return fault_kinds()[std::size_t(std::uint64_t(index) * step % n)].name;
}

void run_sweep(const SweepOptions& options, const std::vector<SweepRow>& done,
               const std::function<void(const SweepRow&)>& tell) {
  Sweep sweep(options);
  for (const int index : indices_of_part(options)) {
    const std::string kind = kind_of(index, options);
    const bool known = std::any_of(done.begin(), done.end(), [&](const SweepRow& row) {
      return row.index == index && row.kind == kind;
    });
    if (!known) tell(sweep.run(index));
  }
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
#include "recording/data/row_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "recording/data/arrival_stamps.h"
#include "recording/data/quoted_text.h"
#include "recording/data/rounded_times.h"

namespace magimu {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// Rates of an IMU: below 1 Hz it cannot follow a hand, and above 10 kHz none delivers samples.
constexpr double kLeastInterval = 1e-4, kMostInterval = 1.0;  // s
// Seconds since 1970, of the years 2001 to 2049. In ms, us and ns these numbers are larger than
// those of any clock that counts since boot with the same intervals.
constexpr double kEpochBegin = 1e9, kEpochEnd = 2.5e9;
// Above, the spacing of doubles exceeds the distance at which two times are told apart (1e-10 s).
constexpr double kHugeTime = 1e6;           // s
constexpr double kGaps = 0.01;              // of the intervals may be gaps
constexpr std::size_t kEnoughToCount = 20;  // intervals, before a column is taken for a counter
constexpr double kMostlyOne = 0.95;         // of a counter's steps; the others are lost samples
constexpr std::size_t kSwapped = 8;         // rows that two writers may put out of order
constexpr double kFarOff = 50.0;            // usual intervals: a row's time is damaged
constexpr double kFewSetBacks = 3.0, kManySetBacks = 0.02;  // and of the rows: no clock does that
constexpr double kRollsOver = 10.0;      // usual intervals that a counter may lose as it does
constexpr double kManyOfOneTime = 0.05;  // of the rows: too many to be a slip

struct TimeUnit {
  const char* name;
  double seconds;
};
constexpr TimeUnit kTimeUnits[] = {{"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}};

// What counters and clocks jump back by: 16, 24, 31 and 32 bits of ticks, and midnight.
constexpr std::array<double, 5> kRollovers = {65536.0, 16777216.0, 2147483648.0, 4294967296.0,
                                              86400.0};

bool is_epoch(double t, double unit) { return t * unit > kEpochBegin && t * unit < kEpochEnd; }

// Mean interval, of rows with an IMU sample where there are any. (The median would be that within a
// burst.)
double usual_interval(const RawRows& rows) {
  constexpr std::uint32_t kImu = RawRows::kAcc | RawRows::kGyr;
  const bool imu = std::ranges::any_of(rows.sensors, [](auto s) { return (s & kImu) != 0; });
  std::vector<double> d;
  double last = kNaN;
  for (std::size_t k = 0; k < rows.time.size(); ++k) {
    if (imu && (rows.sensors[k] & kImu) == 0) continue;
    if (rows.time[k] > last) d.push_back(rows.time[k] - last);
    last = rows.time[k];
  }
  if (d.empty()) return 0.0;
  // Without the longest: gaps, of which there are few.
  if (d.size() > 1) {
    const std::size_t gaps = std::max<std::size_t>(1, std::size_t(kGaps * double(d.size())));
    std::ranges::nth_element(d, d.end() - std::ptrdiff_t(gaps));
    d.resize(d.size() - gaps);
  }
  return std::accumulate(d.begin(), d.end(), 0.0) / double(d.size());
}

class RowTimeReader {
 public:
  RowTimeReader(const RawRows& rows, const RowTimesOptions& options, const RowFailure& fail)
      : rows_(rows), options_(options), fail_(fail) {}

  RowTimes read() {
    if (options_.rate_hz) {
      by_rate();
      return std::move(out_);
    }
    usual_ = usual_interval(rows_);
    const double unit = options_.unit_known ? unit_beside_header() : recognised_unit();
    out_.unit = unit * (options_.unit_known ? options_.unit : 1.0);
    convert(unit);
    order();
    headers();
    spread();
    one_time();
    return std::move(out_);
  }

  double unit(std::vector<std::string>& notes) {
    usual_ = usual_interval(rows_);
    const double unit = recognised_unit();
    notes = std::move(out_.notes);
    return unit;
  }

 private:
  void note(std::string text) { out_.notes.push_back(std::move(text)); }
  // Told by the reader, and by every result.
  void caution(std::string text) {
    out_.notes.push_back(text);
    out_.cautions.push_back(std::move(text));
  }
  std::string column() const { return quoted_text(options_.column); }

  void by_rate() {
    const double h = 1.0 / *options_.rate_hz;
    const std::size_t n = rows_.time.size();
    const bool cycles = options_.counts_cycles;
    const bool counter = cycles || (options_.has_time && counts_samples(rows_));
    for (std::size_t k = 0; k < n; ++k) {
      out_.t.push_back(h * (counter ? rows_.time[k] - rows_.time.front() : double(k)));
    }
    note(fmt::format("the times are k / {:.6g} Hz, with k {}", *options_.rate_hz,
                     cycles    ? "the number of the cycle of lines, one a sensor"
                     : counter ? "counted by column " + column()
                     : options_.has_time
                         ? "the number of the row (column " + column() + " is not used)"
                         : std::string("the number of the row")));
    one_time();
  }

  // A header that names another unit than its column has: 1 where it does not, else what the times
  // are to be multiplied by, where the name only suggested the unit.
  double unit_beside_header() {
    const bool by_header = !options_.unit_in_header.empty() && rows_.time.size() > kEnoughToCount;
    if (!by_header || usual_ == 0.0) return 1.0;
    if (usual_ >= kLeastInterval && usual_ <= kMostInterval) return 1.0;
    const double step = usual_ / options_.unit;  // in the file
    std::vector<TimeUnit> possible;
    for (const TimeUnit& unit : {TimeUnit{"s", 1.0}, kTimeUnits[0], kTimeUnits[1], kTimeUnits[2]}) {
      const double d = step * unit.seconds;
      if (d >= kLeastInterval && d <= kMostInterval) possible.push_back(unit);
    }
    if (possible.empty()) return 1.0;
    const std::string said = fmt::format("{} {}: there would be a row every {:.3g} s", column(),
                                         options_.unit_in_header, usual_);
    if (options_.unit_of_name && possible.size() == 1) {
      note(fmt::format("column {}; it is read as {}, {:.4g} Hz", said, possible[0].name,
                       1.0 / (step * possible[0].seconds)));
      return possible[0].seconds / options_.unit;
    }
    std::vector<std::string> seem, remedies;
    for (const TimeUnit& unit : possible) {
      seem.push_back(fmt::format("{} ({:.4g} Hz)", unit.name, 1.0 / (step * unit.seconds)));
      remedies.push_back(fmt::format("--unit t={}", unit.name));
    }
    fail_(0, fmt::format("column {}; it seems to be in {}", said, fmt::join(seem, " or ")),
          fmt::format("give the unit of time, {}", fmt::join(remedies, " or ")));
    return 1.0;
  }

  // Seconds that the numbers are given in; 1 where they may be seconds.
  double recognised_unit() {
    if (counts_samples(rows_)) {
      fail_(0, fmt::format("column {} counts samples (0, 1, 2, ...): it is not a time", column()),
            "give the rate, --rate HZ; or the unit, --unit t=ms, if there is a sample every "
            "millisecond");
    }
    if (usual_ > 0.0 && usual_ < kLeastInterval && rows_.time.size() > kEnoughToCount) too_fast();
    if (usual_ <= kMostInterval) return 1.0;
    const double first = rows_.time.front();
    std::vector<TimeUnit> possible;
    for (const TimeUnit& unit : kTimeUnits) {
      const double d = usual_ * unit.seconds;
      if (d < kLeastInterval || d > kMostInterval) continue;
      if (is_epoch(first, unit.seconds)) {
        possible = {unit};
        break;
      }
      possible.push_back(unit);
    }
    const std::string pace =
        fmt::format("there is a row every {:.6g} of column {}", usual_, column());
    if (possible.empty()) {
      fail_(0, pace + ", which is no time of an IMU's samples in s, ms, us or ns",
            "give the unit of time, --unit t=NUMBER (one of it in s), or the rate, --rate HZ");
    }
    if (possible.size() > 1) {
      fail_(0,
            fmt::format("{}: {:.4g} Hz if it is in {}, {:.4g} Hz if it is in {}", pace,
                        1.0 / (usual_ * possible[0].seconds), possible[0].name,
                        1.0 / (usual_ * possible[1].seconds), possible[1].name),
            fmt::format("give the unit of time, --unit t={} or --unit t={}", possible[0].name,
                        possible[1].name));
    }
    const TimeUnit& unit = possible.front();
    note(fmt::format("column {} is read as {}{}: {}, {:.4g} Hz", column(), unit.name,
                     is_epoch(first, unit.seconds) ? " since 1970" : "", pace,
                     1.0 / (usual_ * unit.seconds)));
    return unit.seconds;
  }

  // Faster than any IMU in seconds: spreadsheets and MATLAB's datenum count days.
  void too_fast() {
    constexpr double kDay = 86400.0;
    fail_(
        0,
        fmt::format("there is a row every {:.3g} of column {}: {:.4g} Hz if it is in s, {:.4g} Hz "
                    "if it is in days",
                    usual_, column(), 1.0 / usual_, 1.0 / (kDay * usual_)),
        fmt::format("give the unit of time: --unit t=s, --unit t={:.0f} for days, or another "
                    "number (one of it in s)",
                    kDay));
  }

  // To seconds, from the first row where the numbers are huge.
  void convert(double unit) {
    const double first = rows_.time.front();
    const bool shift = !options_.keep_origin && std::abs(first * unit) > kHugeTime;
    const double origin = shift ? first : 0.0;
    out_.t.reserve(rows_.time.size());
    for (const double t : rows_.time) out_.t.push_back((t - origin) * unit);
    usual_ *= unit;
    if (shift) note(fmt::format("the times count from the first row, at {:.3f} s", first * unit));
  }

  // Where the times go back: rows of two writers, a damaged time, a counter that rolled over, a
  // clock that was set.
  void order() {
    double offset = 0.0, newest = -std::numeric_limits<double>::infinity();
    std::array<double, 32> last;  // of each sensor
    last.fill(newest);
    std::size_t late = 0, damaged = 0, first_damaged = 0;
    double set_backs = 0.0;
    const auto damage = [&](std::size_t k) {
      if (damaged++ == 0) first_damaged = rows_.line[k];
      out_.t[k] = kNaN;
    };
    for (std::size_t k = 0; k < out_.t.size(); ++k) {
      if (std::isnan(out_.t[k])) continue;  // known to be damaged
      const double raw = out_.t[k], before = newest - offset;
      double t = raw + offset;
      if (t > newest + far() && k > 0) {
        // Ahead for a moment, and back again.
        if (comes_back(k, offset, newest)) {
          damage(k);
          continue;
        }
        if (t > newest + kHugeTime && !options_.keep_origin) {
          offset = newest + kPartGap - raw;
          t = newest + kPartGap;
          clock_was_set("forward", k, before, raw);
        }
      } else if (t < newest && keeps_order_of_sensors(k, t, last)) {
        ++late;
      } else if (t < newest) {
        const std::size_t back_at = returns_at(k, offset, newest);
        if (back_at > 0) {
          if (t > newest - far()) {
            ++late;
          } else {
            damage(k);
            continue;
          }
        } else if (const double period = rolled_over_by(newest - t); period > 0.0) {
          offset += period;
          t += period;
          note(fmt::format("the counter of the time rolled over at {} {}: {:.6f} s were added",
                           options_.row, rows_.line[k], period));
        } else if (options_.keep_origin) {
          does_not_increase(k, raw, before);
        } else {
          if (++set_backs > kFewSetBacks + kManySetBacks * double(out_.t.size())) {
            does_not_increase(k, raw, before);
          }
          offset = newest + kPartGap - raw;
          t = newest + kPartGap;
          clock_was_set("back", k, before, raw);
        }
      }
      out_.t[k] = t;
      newest = std::max(newest, t);
      for (std::uint32_t s = 0; s < 32; ++s) {
        if ((rows_.sensors[k] >> s & 1U) != 0) last[s] = std::max(last[s], t);
      }
    }
    if (late > 0) note(late_rows_note(late));
    if (damaged > 0) {
      caution(fmt::format("rows with a damaged time: {}, the first in {} {}; they are left out",
                          damaged, options_.row, first_damaged));
    }
  }

  double far() const { return std::max(1.0, kFarOff * usual_); }

  // Of a row far ahead: whether one of the next rows goes on where the rows before it were.
  bool comes_back(std::size_t k, double offset, double newest) const {
    for (std::size_t j = k + 1; j < out_.t.size() && j <= k + kSwapped; ++j) {
      const double t = out_.t[j] + offset;
      if (t >= newest && t < newest + far()) return true;
    }
    return false;
  }

  // Of a row that goes back: the next one of few that goes on where it was; 0 if none.
  std::size_t returns_at(std::size_t k, double offset, double newest) const {
    const std::size_t n = out_.t.size();
    for (std::size_t j = k + 1; j < n && j <= k + kSwapped; ++j) {
      const double t = out_.t[j] + offset;
      if (t > newest && t < newest + far()) return j;
    }
    // At the end of the file there may be none.
    const bool near = out_.t[k] + offset > newest - double(kSwapped) * usual_;
    return near && k > 0 && k + kSwapped >= n ? n : 0;
  }

  bool keeps_order_of_sensors(std::size_t k, double t, const std::array<double, 32>& last) const {
    if (rows_.sensors[k] == 0) return true;
    // A column that the rows of all sensors share says nothing of their order.
    const std::uint32_t sensors = with_rows_of_their_own(rows_.sensors[k]);
    for (std::uint32_t s = 0; s < 32; ++s) {
      if ((sensors >> s & 1U) != 0 && t <= last[s]) return false;
    }
    return true;
  }

  // The period of a counter, in s, that explains a step back; 0 if none does.
  double rolled_over_by(double step) const {
    for (const double ticks : kRollovers) {
      for (const double unit : {1.0, 1e-3, 1e-6, options_.unit}) {
        const bool midnight = ticks == kRollovers.back();
        const double period = midnight ? ticks : ticks * unit;
        if (period < far()) continue;  // rows out of order go back as far
        if (period > step && period < step + kRollsOver * usual_) return period;
      }
    }
    return 0.0;
  }

  void clock_was_set(const char* where, std::size_t k, double from, double to) {
    ++sets_;
    if (sets_ > 5) return;
    caution(fmt::format(
        "the clock was set {} at {} {} (t {:.6g} -> {:.6g} s): a new part begins there, {:.0f} s "
        "later",
        where, options_.row, rows_.line[k], from, to, kPartGap));
  }

  [[noreturn]] void does_not_increase(std::size_t k, double t, double before) {
    fail_(rows_.line[k],
          fmt::format("the time (column {}) does not increase: {} s comes after {} s",
                      options_.column, t, before),
          "sort the rows by time, and cut the file where its clock was set back");
    throw std::logic_error("a failure to read must not return");
  }

  void headers() {
    if (sets_ > 5) caution(fmt::format("the clock was set {} times in all", sets_));
    if (rows_.headers.empty()) return;
    note(fmt::format("header lines within the rows: {}, the first before line {}",
                     rows_.headers.size(),
                     rows_.line[std::min(rows_.headers.front(), rows_.line.size() - 1)]));
  }

  // Rows that were stamped on arrival, for each group of sensors that share rows.
  void spread() {
    std::vector<std::uint32_t> groups;
    std::uint32_t last = 0;
    for (const std::uint32_t all_sensors : rows_.sensors) {
      const std::uint32_t sensors = with_rows_of_their_own(all_sensors);
      if (sensors == last) continue;
      last = sensors;
      std::uint32_t all = sensors;
      std::erase_if(groups, [&all](std::uint32_t g) {
        if ((g & all) == 0) return false;
        all |= g;
        return true;
      });
      groups.push_back(all);
    }
    for (const std::uint32_t group : groups) {
      if ((group & kOwnRows) == 0) continue;
      std::vector<std::size_t> own;
      for (std::size_t k = 0; k < out_.t.size(); ++k) {
        if ((rows_.sensors[k] & group) != 0 && !std::isnan(out_.t[k])) own.push_back(k);
      }
      std::ranges::stable_sort(own, {}, [this](std::size_t k) { return out_.t[k]; });
      std::vector<double> t;
      for (const std::size_t k : own) t.push_back(out_.t[k]);
      const std::optional<EvenTimes> even = even_times(t);
      if (!even) {
        even_out(own, rounded_times(t));
        continue;
      }
      for (std::size_t i = 0; i < own.size(); ++i) out_.t[own[i]] = even->t[i];
      caution(fmt::format(
          "samples are stamped on arrival, about {:.3g} at a time every {:.3g} ms: they were given "
          "even times, {:.5g} Hz (how late they arrived is not known, but is the same for all)",
          even->in_a_burst, 1e3 * even->burst_s, even->rate_hz));
    }
  }

  // Rows whose times were rounded to a step that is long beside the sampling interval.
  void even_out(const std::vector<std::size_t>& own, const std::optional<RoundedTimes>& rounded) {
    if (!rounded) return;
    const std::string what = fmt::format(
        "the times are given in steps of {:.3g} ms, which is {:.0f} % of the sampling interval "
        "({:.4g} ms, {:.4g} Hz)",
        1e3 * rounded->step_s, 100.0 * rounded->step_s * rounded->rate_hz, 1e3 / rounded->rate_hz,
        rounded->rate_hz);
    const std::string told = rounded->t.empty()
                                 ? ": the samples do not come evenly, so that each time is wrong "
                                   "by up to half a step; log more digits of the time"
                                 : ": they were given even times, each within half a step of the "
                                   "one in the file (how late a sensor at another rate is stays "
                                   "unknown by as much); better, log more digits of the time";
    for (std::size_t i = 0; i < rounded->t.size(); ++i) out_.t[own[i]] = rounded->t[i];
    caution(what + told);
  }

  // Several readings of one sensor at one time: the reader keeps the first. Rows of one time that
  // share no sensor, or read the same where they do, are one reading.
  void one_time() {
    std::vector<std::size_t> order(out_.t.size());
    for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
    if (!std::ranges::is_sorted(out_.t)) {
      std::erase_if(order, [this](std::size_t k) { return std::isnan(out_.t[k]); });
      std::ranges::stable_sort(order, {}, [this](std::size_t k) { return out_.t[k]; });
    }
    std::size_t twice = 0, first = 0, beside = 0, first_beside = 0;
    double at = kNaN;
    std::uint32_t seen = 0;
    for (const std::size_t k : order) {
      if (out_.t[k] != at) seen = 0;
      at = out_.t[k];
      const std::uint32_t both = seen & rows_.fresh(k) & kSingle;
      if ((both & RawRows::kVectors) != 0) {
        if (twice++ == 0) first = k;
      } else if (both != 0 && beside++ == 0) {
        first_beside = k;
      }
      seen |= rows_.sensors[k];
    }
    if (beside > 0) {
      note(
          fmt::format("rows with the time of another row and another temperature or current: {}, "
                      "the first in {} {}; the first of those is kept",
                      beside, options_.row, rows_.line[first_beside]));
    }
    if (twice == 0) return;
    if (double(twice) > kManyOfOneTime * double(out_.t.size()) && twice > 1) {
      fail_(rows_.line[first],
            fmt::format("rows with the time of another row and other readings: {}, this one first",
                        twice),
            options_.rate_hz ? "the column counts samples: give every sample a number of its own"
                             : "give every sample a time of its own, or the rate, --rate HZ");
    }
    caution(
        fmt::format("rows with the time of another row and other readings: {}, the first in "
                    "{} {}; those readings are left out",
                    twice, options_.row, rows_.line[first]));
  }

  static constexpr std::uint32_t kSingle = ~RawRows::kMoreMags;
  // What has rows of its own; the others may stand in the rows of every sensor.
  static constexpr std::uint32_t kOwnRows = RawRows::kVectors & ~RawRows::kPosition;
  // Of a row's sensors; all of them where none has.
  static std::uint32_t with_rows_of_their_own(std::uint32_t sensors) {
    const std::uint32_t own = sensors & kOwnRows;
    return own != 0 ? own : sensors;
  }

  const RawRows& rows_;
  const RowTimesOptions& options_;
  const RowFailure& fail_;
  double usual_ = 0.0;  // interval of rows: in the file's unit, then in s
  int sets_ = 0;
  RowTimes out_;
};

}  // namespace

bool counts_samples(const RawRows& rows) {
  const std::vector<double>& t = rows.time;
  std::size_t ones = 0, steps = 0;
  for (std::size_t k = 0; k < t.size(); ++k) {
    if (t[k] != std::floor(t[k])) return false;
    if (k == 0 || !(t[k] > t[k - 1])) continue;
    ++steps;
    ones += t[k] - t[k - 1] == 1.0 ? 1 : 0;
  }
  return steps >= kEnoughToCount && double(ones) >= kMostlyOne * double(steps) &&
         !many_of_one_time(rows);
}

bool many_of_one_time(const RawRows& rows) {
  std::size_t same = 0;
  for (std::size_t k = 1; k < rows.time.size(); ++k) {
    const bool shares = (rows.fresh(k) & rows.sensors[k - 1] & RawRows::kVectors) != 0;
    same += shares && rows.time[k] == rows.time[k - 1] ? 1 : 0;
  }
  return double(same) > kManyOfOneTime * double(rows.time.size());
}

std::string late_rows_note(std::size_t rows) {
  return fmt::format("rows that came late and were put in the order of time: {}", rows);
}

RowTimes row_times(const RawRows& rows, const RowTimesOptions& options, const RowFailure& fail) {
  return RowTimeReader(rows, options, fail).read();
}

double recognised_time_unit(const RawRows& rows, const RowTimesOptions& options,
                            const RowFailure& fail, std::vector<std::string>& notes) {
  return RowTimeReader(rows, options, fail).unit(notes);
}

}  // namespace magimu

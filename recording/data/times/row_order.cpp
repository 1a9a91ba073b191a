// SPDX-License-Identifier: BSD-3-Clause
#include "recording/data/times/row_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace magimu {
namespace {

constexpr double kNotATime = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kSwapped = 8;  // rows that two writers may put out of order
constexpr double kFarOff = 50.0;     // usual intervals: a row's time is damaged
constexpr double kFewSetBacks = 3.0, kManySetBacks = 0.02;  // and of the rows: no clock does that
constexpr double kRollsOver = 10.0;  // usual intervals that a counter may lose as it does
constexpr int kMostSetsTold = 5;     // one by one; of wording

// What counters and clocks jump back by: 16, 24, 31 and 32 bits of ticks, and midnight.
constexpr std::array<double, 5> kRollovers = {65536.0, 16777216.0, 2147483648.0, 4294967296.0,
                                              86400.0};

class RowOrder {
 public:
  RowOrder(const RawRows& rows, const RowTimesOptions& options, double usual_s,
           const RowFailure& fail, RowTimes& out)
      : rows_(rows), options_(options), usual_(usual_s), fail_(fail), out_(out) {}

  // Where the times go back: rows of two writers, a damaged time, a counter that rolled over, a
  // clock that was set.
  void put_on_one_clock() {
    double offset = 0.0, newest = -std::numeric_limits<double>::infinity();
    std::array<double, 32> last;  // of each sensor
    last.fill(newest);
    std::size_t late = 0, damaged = 0, first_damaged = 0;
    double set_backs = 0.0;
    const auto damage = [&](std::size_t k) {
      if (damaged++ == 0) first_damaged = rows_.line[k];
      out_.t[k] = kNotATime;
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
    if (sets_ > kMostSetsTold) caution(fmt::format("the clock was set {} times in all", sets_));
  }

 private:
  void note(std::string text) { out_.notes.push_back(std::move(text)); }
  // Told by the reader, and by every result.
  void caution(std::string text) {
    out_.notes.push_back(text);
    out_.cautions.push_back(std::move(text));
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
    if (sets_ > kMostSetsTold) return;
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

  const RawRows& rows_;
  const RowTimesOptions& options_;
  double usual_;  // s
  const RowFailure& fail_;
  RowTimes& out_;
  int sets_ = 0;
};

}  // namespace

std::string late_rows_note(std::size_t rows) {
  return fmt::format("rows that came late and were put in the order of time: {}", rows);
}

void put_on_one_clock(const RawRows& rows, const RowTimesOptions& options, double usual_s,
                      const RowFailure& fail, RowTimes& out) {
  RowOrder(rows, options, usual_s, fail, out).put_on_one_clock();
}

}  // namespace magimu

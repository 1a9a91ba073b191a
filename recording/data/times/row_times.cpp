// SPDX-License-Identifier: BSD-3-Clause
#include "recording/data/times/row_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "recording/data/quoted_text.h"
#include "recording/data/times/arrival_stamps.h"
#include "recording/data/times/rounded_times.h"
#include "recording/data/times/row_order.h"
#include "recording/data/times/time_unit.h"

namespace magimu {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

class RowTimeReader {
 public:
  RowTimeReader(const RawRows& rows, const RowTimesOptions& options, const RowFailure& fail)
      : rows_(rows), options_(options), fail_(fail) {}

  RowTimes read() {
    if (options_.rate_hz) {
      by_rate();
      return std::move(out_);
    }
    usual_ = usual_row_interval(rows_);
    const double unit = (options_.unit_known ? unit_beside_header : unit_of_times)(
        rows_, options_, usual_, fail_, out_.notes);
    out_.unit = unit * (options_.unit_known ? options_.unit : 1.0);
    convert(unit);
    put_on_one_clock(rows_, options_, usual_, fail_, out_);
    headers();
    spread();
    one_time();
    return std::move(out_);
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
    const bool cycles = options_.counts_cycles, each = options_.counts_each_sensor;
    const bool counter = cycles || each || (options_.has_time && counts_samples(rows_));
    for (std::size_t k = 0; k < n; ++k) {
      out_.t.push_back(h * (counter ? rows_.time[k] - rows_.time.front() : double(k)));
    }
    note(fmt::format("the times are k / {:.6g} Hz, with k {}", *options_.rate_hz,
                     cycles ? "the number of the cycle of lines, one a sensor"
                     : each ? "the number of the row of its sensor: they come one after the other"
                     : counter ? "counted by column " + column()
                     : options_.has_time
                         ? "the number of the row (column " + column() + " is not used)"
                         : std::string("the number of the row")));
    one_time();
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

  void headers() {
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
    const std::string told =
        rounded->t.empty() ? ": the samples do not come evenly, so that each time is wrong "
                             "by up to half a step; log more digits of the time"
                           : std::string(": they were given even times, each within ") +
                                 (rounded->within_s < rounded->step_s ? "half a" : "a") +
                                 " step of the "
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
  const RawRows& rows_;
  const RowTimesOptions& options_;
  const RowFailure& fail_;
  double usual_ = 0.0;  // interval of rows: in the file's unit, then in s
  RowTimes out_;
};

}  // namespace

RowTimes row_times(const RawRows& rows, const RowTimesOptions& options, const RowFailure& fail) {
  return RowTimeReader(rows, options, fail).read();
}

double recognised_time_unit(const RawRows& rows, const RowTimesOptions& options,
                            const RowFailure& fail, std::vector<std::string>& notes) {
  return unit_of_times(rows, options, usual_row_interval(rows), fail, notes);
}

}  // namespace magimu

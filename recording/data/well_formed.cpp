// SPDX-License-Identifier: BSD-3-Clause
#include "recording/data/well_formed.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "recording/data/error.h"
#include "recording/data/quoted_text.h"

namespace magimu {
namespace {

void require_same_length(const Recording& r, const std::string& name, std::size_t times,
                         std::size_t values) {
  if (times == values) return;
  throw InputError(r.name, 0, 0, fmt::format("{} has {} times and {} values", name, times, values),
                   "give each sample one of each");
}

void require_finite_times(const Recording& r, const std::string& name,
                          const std::vector<double>& t) {
  const auto bad = std::ranges::find_if(t, [](double x) { return !std::isfinite(x); });
  if (bad == t.end()) return;
  throw InputError(r.name, 0, 0,
                   fmt::format("the time of sample {} of {} is {}, which is no finite number",
                               bad - t.begin(), name, *bad),
                   "leave out samples whose times are not known");
}

template <class Series>
void require_series(const Recording& r, const std::string& name, const Series& series) {
  require_same_length(r, name, series.t.size(), series.v.size());
  require_finite_times(r, name, series.t);
}

// May be empty where it is not known.
void require_known_or_empty(const Recording& r, const char* name, std::size_t times,
                            std::size_t values) {
  if (values > 0) require_same_length(r, name, times, values);
}

void require_names(const Recording& r) {
  if (r.mag_names.empty() || r.mag.empty()) return;  // a missing magnetometer is reported elsewhere
  if (r.mag_names.size() != r.mag.size()) {
    throw InputError(r.name, 0, 0,
                     fmt::format("it has {} magnetometers and {} names of magnetometers",
                                 r.mag.size(), r.mag_names.size()),
                     "give one name each, or none at all");
  }
  std::set<std::string> seen{"acc", "gyr"};
  for (const std::string& name : r.mag_names) {
    if (!name.empty() && seen.insert(name).second) continue;
    throw InputError(r.name, 0, 0,
                     name.empty() ? "a magnetometer's name is empty"
                                  : fmt::format("two sensors have the name {}", quoted_text(name)),
                     "give each magnetometer a name of its own");
  }
}

}  // namespace

std::vector<std::string> usual_mag_names(std::size_t magnetometers) {
  std::vector<std::string> out;
  for (std::size_t m = 0; m < magnetometers; ++m) {
    out.push_back(magnetometers == 1 ? "mag" : fmt::format("mag{}", m + 1));
  }
  return out;
}

void require_well_formed(const Recording& r) {
  require_names(r);
  const std::vector<std::string> names =
      r.mag_names.empty() ? usual_mag_names(r.mag.size()) : r.mag_names;
  require_series(r, "acc", r.acc);
  require_series(r, "gyr", r.gyr);
  for (std::size_t m = 0; m < r.mag.size(); ++m) require_series(r, names[m], r.mag[m]);
  for (const auto& [name, series] : r.aux) require_series(r, name, series);
  if (r.pos) require_series(r, "pos", *r.pos);
  if (r.truth) {
    const std::size_t n = r.truth->t.size();
    require_same_length(r, "the true motion", n, r.truth->nRb.size());
    require_finite_times(r, "the true motion", r.truth->t);
    require_known_or_empty(r, "the true position", n, r.truth->position.size());
    require_known_or_empty(r, "the true motion's validity", n, r.truth->valid.size());
    require_known_or_empty(r, "the true motion's phase", n, r.truth->moving.size());
  }
}

WellFormed::WellFormed(const std::vector<const Recording*>& given) {
  for (const Recording* recording : given) {
    if (recording == nullptr) {
      throw InputError("", 0, 0, "a recording is a null pointer", "give recordings that exist");
    }
    require_well_formed(*recording);
    if (recording->mag_names.size() != recording->mag.size()) {
      named_.push_back(*recording);
      named_.back().mag_names = usual_mag_names(recording->mag.size());
      recording = &named_.back();
    }
    recordings_.push_back(recording);
  }
}

}  // namespace magimu

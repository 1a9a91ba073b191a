// SPDX-License-Identifier: BSD-3-Clause
#include "study/method_table.h"

#include <cmath>

namespace magimu {

StudyTable rmse_table(const std::string& name, const std::string& title,
                      const std::string& setting_column) {
  return {name,
          title,
          {setting_column, "method", "data sets", "parameters", "unit", "RMSE", "bound",
           "RMSE / bound", "99 % from", "to", "of ten, 0.5 %", "99.5 %", "published",
           "published / RMSE"},
          {}};
}

void add_rmse(StudyTable& table, const StudyCell& setting, const std::string& method,
              const MethodSummary& summary, const std::optional<PublishedRmse>& published) {
  for (std::size_t g = 0; g < summary.groups.size(); ++g) {
    const GroupStatistics& group = summary.groups[g];
    const double printed = published && g < published->size() ? (*published)[g] : kNoValue;
    table.rows.push_back({setting, method, double(summary.runs), group.name, group.unit, group.rmse,
                          group.bound, group.ratio(), std::sqrt(group.band.low),
                          std::sqrt(group.band.high), summary.ten[g].low, summary.ten[g].high,
                          printed, printed / group.rmse});
  }
}

StudyTable method_table(const std::string& name, const std::string& title,
                        const std::string& setting_column) {
  return {name,
          title,
          {setting_column, "method", "data sets", "without a result", "stopped early",
           "most iterations", "NEES", "99 % from", "to", "from the MAP, median sigma",
           "most sigma", "seconds, median", "published seconds"},
          {}};
}

void add_method(StudyTable& table, const StudyCell& setting, const std::string& method,
                const MethodSummary& s, double published_seconds) {
  table.rows.push_back({setting, method, double(s.runs), double(s.failed), double(s.not_converged),
                        double(s.most_iterations), s.nees, s.nees_band.low, s.nees_band.high,
                        s.median_distance, s.largest_distance, s.median_seconds,
                        published_seconds});
}

void check_bands(Study& study, const std::string& of, const MethodSummary& s) {
  for (std::size_t g = 0; g < s.groups.size(); ++g) {
    const GroupStatistics& group = s.groups[g];
    const Band& wide = s.wide_groups[g].band;
    study.checks.push_back({of + ": RMSE of " + group.name + " over its bound", group.ratio(),
                            std::sqrt(group.band.low), std::sqrt(group.band.high), true,
                            std::sqrt(wide.low), std::sqrt(wide.high)});
  }
  study.checks.push_back({of + ": NEES of all 19", s.nees, s.nees_band.low, s.nees_band.high, true,
                          s.wide_nees_band.low, s.wide_nees_band.high});
}

void check_limit(Study& study, const std::string& what, double value, double low, double high) {
  study.checks.push_back({what, value, low, high, false, low, high});
}

PublishedRmse rmse_of(const MethodSummary& summary) {
  PublishedRmse out{kNoValue, kNoValue, kNoValue, kNoValue};
  for (std::size_t g = 0; g < out.size() && g < summary.groups.size(); ++g) {
    out[g] = summary.groups[g].rmse;
  }
  return out;
}

}  // namespace magimu

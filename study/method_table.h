// SPDX-License-Identifier: BSD-3-Clause
// Tables and checks that several experiments make of methods' errors.
#pragma once

#include "study/method_runs.h"
#include "study/published.h"

namespace magimu {

// One row a group of parameters: RMSE, bound, ratio with its band, range of ten, published.
StudyTable rmse_table(const std::string& name, const std::string& title,
                      const std::string& setting_column);
void add_rmse(StudyTable& table, const StudyCell& setting, const std::string& method,
              const MethodSummary& summary, const std::optional<PublishedRmse>& published);

// One row: runs, iterations, seconds, NEES, distance from the MAP.
StudyTable method_table(const std::string& name, const std::string& title,
                        const std::string& setting_column);
void add_method(StudyTable& table, const StudyCell& setting, const std::string& method,
                const MethodSummary& summary, double published_seconds);

// RMSE over the bound of each group, and NEES, in the bands of chance.
void check_bands(Study& study, const std::string& of, const MethodSummary& summary);
// A figure that must lie between two limits.
void check_limit(Study& study, const std::string& what, double value, double low, double high);

inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();

// RMSE of o_a, o_w, o_m, D.
PublishedRmse rmse_of(const MethodSummary& summary);

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// Units by what is the same for everyone: gravity, the Earth's field, and that directions turn as
// fast as the gyroscope says.
#include <fmt/format.h>

#include <utility>

#include "recording/checks/unit_issues.h"
#include "recording/data/told_units.h"

namespace magimu {
namespace {

// A unit that the user gave by an option is believed: what speaks against it is told and refuses
// nothing. Only whoever wrote the file knows better than the readings.
Issue as_told(Issue issue, const Recording& r, const std::string& quantity) {
  if (issue.severity != Severity::kFatal || issue.kind == "normalised") return issue;
  if (!unit_was_told(r.file_units, quantity)) return issue;
  issue.severity = Severity::kCaution;
  issue.remedy = fmt::format("the unit that was given, {}, is believed; else: {}",
                             unit_text(quantity, file_unit(r, quantity)), issue.remedy);
  return issue;
}

}  // namespace

std::vector<Issue> check_units(const Recording& r) {
  std::vector<Issue> issues;
  const auto add = [&](const char* quantity, std::vector<Issue>&& more) {
    for (Issue& issue : more) issues.push_back(as_told(std::move(issue), r, quantity));
  };
  if (r.acc.size() >= kFewestToJudge) {
    const std::vector<Issue> wrong = check_acc_unit(r);
    add("acc", wrong.empty() ? check_acc_scale(r) : std::vector<Issue>(wrong));
  }
  if (r.gyr.size() >= kFewestToJudge) add("gyr", check_gyr_unit(r));
  for (std::size_t i = 0; i < r.mag.size(); ++i) {
    const std::string name = i < r.mag_names.size() ? r.mag_names[i] : "mag";
    // One that never changes is dead, whatever its unit.
    if (r.mag[i].size() >= kFewestToJudge && !all_constant(r.mag[i]))
      add("mag", check_mag_unit(r, name, r.mag[i]));
  }
  return issues;
}

}  // namespace magimu

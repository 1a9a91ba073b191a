// SPDX-License-Identifier: BSD-3-Clause
#include "recording/data/set_aside.h"

#include <fmt/format.h>

namespace magimu {
namespace {

struct KindText {
  const char *kind, *what, *remedy;
};
constexpr KindText kKinds[] = {
    {"not_finite", "not a finite number", "leave out samples that the sensor did not deliver"},
    {"range", "beyond any sensor's range", "check the logger: such numbers are made on the way"},
    {"spike", "a jump away from all neighbours",
     "check the logger and the wires: no motion makes such a reading"},
    {"stuck", "repeated to the last bit where the sensor should change",
     "the sensor or its bus hung: check the wires, and record again if it was for long"},
    {"zeros", "exactly 0, 0, 0, which is no measurement",
     "leave the fields empty where the sensor has no sample"},
    {"dead_zone", "one reading for all small rates (a dead band)",
     "switch the dead band or the automatic zero off: slow turns are lost, and with them the bias"},
    {"sentinel", "one impossible value again and again, by which a driver says that it has none",
     "leave the fields empty where the sensor has no sample"},
    {"wrap", "off by its whole range: the number turned over", "choose a larger range"},
    {"disturbed", "in seconds that do not fit the rest",
     "keep magnets, iron and electric devices away"},
    {"clipped", "clipped at the end of the range",
     "choose a larger range, move more gently, or go away from magnets"},
};

const KindText& text_of(const SetAside& s) {
  for (const KindText& k : kKinds) {
    if (s.kind == k.kind) return k;
  }
  return kKinds[0];
}

}  // namespace

std::string sentence(const SetAside& s) {
  std::string when;
  if (s.count > 1) {
    when = fmt::format("; {} between {:.2f} and {:.2f} s", "they lie", s.begin_s, s.end_s);
  }
  const double share = double(s.count) / double(s.of);
  const std::string percent = share > kSetAsideFew ? fmt::format(" ({:.1f} %)", 100.0 * share) : "";
  return fmt::format("{}: {} of {} samples{} {} set aside, {}: {}{}", s.sensor, s.count, s.of,
                     percent, s.count == 1 ? "is" : "are", text_of(s).what, s.example, when);
}

std::string remedy(const SetAside& s) { return text_of(s).remedy; }

double lost_share(const SetAside& s) {
  const bool no_loss = s.kind == "zeros" || s.kind == "disturbed";
  return s.of == 0 || no_loss ? 0.0 : double(s.count) / double(s.of);
}

}  // namespace magimu

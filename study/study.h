// SPDX-License-Identifier: BSD-3-Clause
// The experiments of Huang et al. 2025 again, with both rivals, and those that its figures ask for:
// what each is about, its tables and figures with the published numbers beside them, and what a run
// shows to be the reason where the two differ. `magimu study` writes it; docs/study.md tells what
// one run gave.
//
//   const Study study = run_study("accuracy", {.runs = 100});
//   for (const StudyTable& table : study.tables) ...
//
// Seeds are fixed: the same options give the same figures (but for seconds), whatever the number of
// threads.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace magimu {

struct StudyOptions {
  // Data sets of each setting. What takes seconds a data set (the published optimizer of Kok's
  // likelihood, arrays) has fewer, and says how many.
  int runs = 100;
  int threads =
      0;  // data sets at a time; each is computed on one. 0: as many as there are processors
  // Everything in small, for tests: few data sets and settings. Its figures mean little.
  bool brief = false;
  // A folder of recordings of an array (recording/arrays/array_mat.h), for "downstream"; empty:
  // only the simulated room.
  std::string recordings;
  // What is being done, and how far the experiment is, 0 to 1.
  std::function<void(const std::string& what, double share)> progress;
};

// A number that is none has no value; a column says what its numbers are.
inline constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();
using StudyCell = std::variant<std::string, double>;

struct StudyTable {
  std::string name;   // of its file, without the extension
  std::string title;  // a sentence
  std::vector<std::string> columns;
  std::vector<std::vector<StudyCell>> rows;
};

struct StudyCurve {
  std::string name;
  std::vector<double> x, y;
  bool published = false;  // drawn dashed
};

struct StudyFigure {
  std::string name;  // of its file, without the extension
  std::string title, x_label, y_label;
  bool log_x = false, log_y = false;
  std::vector<StudyCurve> curves;
};

// A figure with the band in which it is to lie.
struct StudyCheck {
  std::string what;
  double value = kNoValue, low = 0.0, high = 0.0;
  // Bands of chance: 99 % of such figures lie within low and high, 99.99 % within the wider one.
  // Of the others (a limit that must hold) the wider band is not used.
  bool by_chance = false;
  double wide_low = 0.0, wide_high = 0.0;

  bool inside() const { return low <= value && value <= high; }
  bool inside_wide() const { return wide_low <= value && value <= wide_high; }
};

struct Study {
  std::string name, title;
  std::string question;  // what it is to answer, and how, in sentences
  std::vector<StudyTable> tables;
  std::vector<StudyFigure> figures;
  std::vector<StudyCheck> checks;
  std::vector<std::string> findings;  // sentences, each from figures of this run
  double seconds = 0.0;
};

// In the order in which "all" does them.
const std::vector<std::string>& study_names();

class StudyRuns;
// name: one of study_names(). InputError of another, or of a folder without recordings. `runs`:
// what experiments share is computed once; nothing: each for itself.
Study run_study(const std::string& name, const StudyOptions& options);
std::vector<Study> run_studies(const std::vector<std::string>& names, const StudyOptions& options);

// Of figures at 99 % at most two may be outside, none at 99.99 %; every limit holds. In a sentence.
struct StudyVerdict {
  int by_chance = 0, outside = 0, far_outside = 0, limits = 0, broken = 0;
  std::string sentence;
};
StudyVerdict judge(const std::vector<Study>& studies);

}  // namespace magimu

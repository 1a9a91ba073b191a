// SPDX-License-Identifier: BSD-3-Clause
// The tables of real_data.cpp, and the part of docs/real_data.md that a program can write: tables
// between markers,
//
//   <!-- bench_real_data: orientation -->
//   ... replaced ...
//   <!-- end -->
//
// and pictures beside it. What stands outside of the markers is written by people.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bench/real/blind_starts.h"
#include "bench/real/real_results.h"

namespace magimu {

struct RealStudy {
  std::vector<RealResult> results;
  std::vector<CrossApplication> cross;
  std::vector<std::string> repeated;  // numbers of the recordings of one sensor
  Repeatability repeatability;
  std::vector<std::pair<std::string, BlindStarts>> starts;  // by number
};

// Markdown tables.
std::string orientation_table(const RealStudy& study);
std::string limits_table(const RealStudy& study);
std::string parameter_table(const RealStudy& study);
std::string verdict_list(const RealStudy& study);
std::string cross_table(const RealStudy& study);
std::string repeatability_table(const RealStudy& study);
std::string starts_table(const RealStudy& study);

// File name to SVG text.
std::map<std::string, std::string> pictures(const RealStudy& study);

// The document with the content of this block replaced. std::runtime_error, which names the block,
// if its markers are not there.
std::string with_block(const std::string& document, const std::string& name,
                       const std::string& content);

// Updates folder/real_data.md and writes folder/pictures/*.svg: every file whole or not at all, and
// none if the document lacks a marker. Blind starts that were not made leave their table as it is.
void write_document(const RealStudy& study, const std::string& folder);

}  // namespace magimu

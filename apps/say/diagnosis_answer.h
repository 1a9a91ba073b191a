// SPDX-License-Identifier: BSD-3-Clause
// What a diagnosis says, in words, in the order in which people ask. The terminal
// (diagnosis_table.h) and the page (diagnosis_report.h) use these words.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/result/diagnosis.h"

namespace magimu::apps {

// The answer in a sentence; its reasons, and the findings' sentences, are in the diagnosis.
std::string headline(const Diagnosis& diagnosis);

// Reasons of calibrate()'s verdict that the diagnosis has not given in its own words.
std::vector<std::string> unsaid_reasons(const Diagnosis& diagnosis);

// What the diagnosis adds to the verdict, which is calibrate()'s: the verdict with the causes that
// were found, and that something is not explained. Empty: nothing.
std::vector<std::string> added_to_verdict(const Diagnosis& diagnosis);

// Does the stored calibration still hold: a sentence.
std::string against_headline(const Against& against);

// ("noise_scale", "mag") -> "noise scale, magnetometer".
std::string effect_title(const std::string& effect, const std::string& channel = "");

// What became of a candidate.
enum class Outcome { kFound, kExplained, kNotFound, kUntested };
bool is_finding_of(const ScanEntry& entry, const Finding& finding);
Outcome outcome_of(const ScanEntry& entry, const Diagnosis& diagnosis);
std::vector<const ScanEntry*> entries_with(Outcome outcome, const Diagnosis& diagnosis);

// Why a candidate could not be tested.
std::string needs_words(const ScanEntry& entry);
// The size at which a candidate would be found in nine of ten cases.
std::string detectable_words(const ScanEntry& entry);

// "0.0110 ± 0.0001 s"
std::string size_words(const FoundParameter& parameter);

// "Field drift, clock scale: why. To separate: a motion; another one." A sentence for every reason.
std::vector<std::string> confusable_words(const std::vector<Confusable>& confusable);

// By how much left-out data are predicted better, in nats.
double heldout_gain(const Gain& gain);
std::string heldout_number(const Gain& gain);  // the same, as text
std::string heldout_words(const Gain& gain);

// Whether the residuals in a finding's gain are those of the whole model, without and with it, and
// do not grow: a model that lacks something may leave less than noise, and more once it lacks
// nothing. (Those of a source that is not in the model are of its excursions only, and cannot be
// compared with others.)
bool residual_of_model(const Finding& finding);

// One parameter of the calibration, before and after the extensions.
struct Moved {
  std::string name, unit;  // for people: "magnetometer bias x"
  double before = 0.0, sigma_before = 0.0, after = 0.0, sigma_after = 0.0;
  double sigmas() const;  // how far it moved, in its own standard deviations as first stated
};
std::vector<Moved> moved_parameters(const Diagnosis& diagnosis);

}  // namespace magimu::apps

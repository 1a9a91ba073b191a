// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/result/diagnosis_json.h"

#include <cmath>

#include "calibration/result/calibration_json.h"

namespace magimu {
namespace {

using Json = nlohmann::ordered_json;

Json departures(const std::vector<Departure>& all) {
  Json out = Json::array();
  for (const Departure& d : all) {
    out.push_back({{"channel", d.channel},
                   {"statistic", d.statistic},
                   {"observed", d.observed},
                   {"predicted", d.predicted},
                   {"predicted_band", d.predicted_band},
                   {"z", d.z}});
    if (!(d.end_s > d.begin_s)) continue;
    out.back()["begin_s"] = d.begin_s;
    out.back()["end_s"] = d.end_s;
    out.back()["recording"] = d.recording;
  }
  return out;
}

Json scan_entry(const ScanEntry& e) {
  return {{"effect", e.effect},           {"channel", e.channel}, {"parameters", e.parameters},
          {"statistic", e.statistic},     {"dof", e.dof},         {"p_value", e.p_value},
          {"significant", e.significant}, {"needs", e.needs},     {"detectable", e.detectable}};
}

Json gain(const Gain& g) {
  return {{"heldout_nll_before", g.heldout_nll_before},
          {"heldout_nll_after", g.heldout_nll_after},
          {"bic_delta", g.bic_delta},
          {"residual_rms_before", g.residual_rms_before},
          {"residual_rms_after", g.residual_rms_after}};
}

Json found(const std::vector<FoundParameter>& parameters) {
  Json out = Json::array();
  for (const FoundParameter& p : parameters) {
    out.push_back({{"name", p.name}, {"value", p.value}, {"sigma", p.sigma}, {"unit", p.unit}});
  }
  return out;
}

Json finding(const Finding& f) {
  Json confusable = Json::array();
  for (const Confusable& c : f.confusable_with) {
    confusable.push_back(
        {{"effect", c.effect}, {"why", c.why}, {"motion_that_separates", c.motion_that_separates}});
  }
  return {{"effect", f.effect},     {"channel", f.channel},
          {"sentence", f.sentence}, {"parameters", found(f.parameters)},
          {"p_value", f.p_value},   {"probability", f.probability},
          {"gain", gain(f.gain)},   {"confusable_with", confusable}};
}

Json missing(const std::vector<MissingState>& all) {
  Json out = Json::array();
  for (const MissingState& m : all) {
    out.push_back({{"channel", m.channel},
                   {"frame", m.frame},
                   {"gain_nats", m.gain_nats},
                   {"size", m.size},
                   {"unit", m.unit},
                   {"memory_s", m.memory_s},
                   {"taken_by_findings", m.taken_by_findings()},
                   {"taken_by_place", m.taken_by_place},
                   {"left_nats", m.left_nats}});
    if (!m.noise.empty()) out.back()["noise"] = m.noise;
    if (std::isfinite(m.left_beside_acc_offset)) {
      out.back()["left_beside_acc_time_offset"] = m.left_beside_acc_offset;
      out.back()["acc_time_offset_s"] = m.acc_offset_s;
    }
  }
  return out;
}

Json field_of_place(const PlaceCheck& p) {
  Json fields = Json::array();
  for (const HarmonicField& f : p.fields) {
    fields.push_back({{"middle_m", std::vector<double>(f.middle.begin(), f.middle.end())},
                      {"reach_m", f.reach_m},
                      {"size_uT", std::vector<double>(f.size_uT.begin(), f.size_uT.end())}});
  }
  return {{"named", p.named()},
          {"ahead", p.ahead},
          {"ahead_nats", p.ahead_nats},
          {"rival", p.rival},
          {"stays", p.stays},
          {"comes_back", p.comes_back},
          {"left_out_gain_nats", p.predicts_nats()},
          {"blocks", p.blocks},
          {"blocks_better", p.blocks_better},
          {"block_s", p.block_s},
          {"guard_s", p.guard_s},
          {"order", p.order},
          {"gain_nats", p.gain_nats},
          {"process_nats", p.process_nats},
          {"left_nats", p.left_nats},
          {"share", p.taken_share()},
          {"field_uT", p.field_uT},
          {"gradient_uT_m", p.gradient_uT_m},
          {"reach_m", p.reach_m},
          {"fields", fields}};
}

Json at_rest(const AtRest& a) {
  return {{"rests", a.rests},     {"change_uT", a.change_uT}, {"change_sigmas", a.change_sigmas},
          {"begin_s", a.begin_s}, {"end_s", a.end_s},         {"recording", a.recording}};
}

Json missing_series(const std::vector<MissingSeries>& all) {
  const auto rows = [](const std::vector<Vector3>& v) {
    Json out = Json::array();
    for (const Vector3& x : v) out.push_back({x[0], x[1], x[2]});
    return out;
  };
  Json out = Json::array();
  for (const MissingSeries& s : all) {
    out.push_back({{"channel", s.channel},
                   {"frame", s.frame},
                   {"unit", s.unit},
                   {"recording", s.recording},
                   {"t", s.t},
                   {"mean", rows(s.mean)},
                   {"sigma", rows(s.sigma)}});
  }
  return out;
}

Json against(const Against& a) {
  Json groups = Json::array();
  for (const Change& c : a.groups) {
    groups.push_back({{"group", c.group},
                      {"changed", c.changed},
                      {"sentence", c.sentence},
                      {"parameters", found(c.parameters)},
                      {"statistic", c.statistic},
                      {"dof", c.dof},
                      {"p_value", c.p_value},
                      {"smallest_seen", c.smallest},
                      {"unit", c.unit}});
  }
  return {{"calibration", a.calibration},
          {"tested", a.tested},
          {"changed", a.changed()},
          {"told", a.told},
          {"changes_within", a.within},
          {"fits_only", a.fits_only},
          {"groups", groups},
          {"notes", a.notes}};
}

}  // namespace

Json to_json(const Diagnosis& d) {
  Json out;
  out["format"] = "magimu-diagnosis/1";
  out["recordings"] = d.recordings;
  out["answer"] = to_string(d.answer);
  out["answer_evidence"] = d.evidence;
  out["next_step"] = d.next_step;
  out["departures"] = departures(d.departures);
  out["departures_after"] = departures(d.departures_after);
  out["statistics"] = d.statistics;
  out["scan"] = Json::array();
  for (const ScanEntry& e : d.scan) out["scan"].push_back(scan_entry(e));
  out["findings"] = Json::array();
  for (const Finding& f : d.findings) out["findings"].push_back(finding(f));
  out["set_aside"] = set_aside_json(d.after.set_aside);
  out["unexplained"] = {{"detected", d.unexplained.detected},
                        {"channels", d.unexplained.channels},
                        {"evidence", d.unexplained.evidence}};
  out["evidence"] = missing(d.missing);
  if (d.place) out["field_of_place"] = field_of_place(*d.place);
  if (d.field_at_rest) out["field_at_rest"] = at_rest(*d.field_at_rest);
  out["disturbance"] = missing_series(d.missing_series);
  if (d.against) out["against"] = against(*d.against);
  out["calibration_before"] = to_json(d.before);
  out["calibration_after"] = to_json(d.after);
  out["notes"] = d.notes;
  out["false_alarm_rate"] = d.false_alarm_rate;
  out["seconds"] = d.seconds;
  return out;
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// Runs, watches and compares: board_session.h.
#include "bench/boards/board_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <filesystem>

namespace magimu {

using nlohmann::json;

double board_sigmas(const json& wanted, const json& calibration) {
  if (wanted.is_null() || calibration.is_null()) return -1.0;
  const Distance d = distance(wanted, calibration);
  return d.parameters > 0 ? d.worst_sigma : -1.0;
}

BoardRow board_row(const std::string& study, int index) {
  BoardRow row;
  row.study = study;
  row.index = index;
  row.kind = board_kind(study, index);
  return row;
}

std::string board_trust(const json& calibration) {
  const json::json_pointer at("/trust/verdict");
  return calibration.contains(at) ? calibration[at].get<std::string>() : "";
}

BoardProcess& BoardSession::start(const std::vector<std::string>& arguments) {
  lines_before_ = lines().size();
  std::vector<std::string> command = {options_.program, "stream"};
  command.insert(command.end(), arguments.begin(), arguments.end());
  process_ = std::make_unique<BoardProcess>(folder_.path(), command);
  return *process_;
}

long BoardSession::kill() {
  // First the death, then what it has said: a line that is there was printed before.
  process_->signal(SIGKILL);
  process_->wait(options_.patience_s);
  return acknowledged();
}

void BoardSession::finish(BoardRow& row) {
  const BoardEnd end = process_->wait(options_.patience_s);
  row.problem += end.problem(errors());
  row.seconds = std::max(row.seconds, end.processor_s);
  row.memory_mb = std::max(row.memory_mb, end.resident_mb);
}

void BoardSession::interrupt_when_silent(BoardRow& row) {
  if (!falls_silent(options_.patience_s) && process_->running()) {
    row.problem += "it does not notice that the source is silent. ";
  }
  process_->signal(SIGINT);
  finish(row);
}

void BoardSession::check_restart(long acknowledged, BoardRow& row) const {
  const std::vector<json> since = new_lines();
  const long known = since.empty() ? 0 : since.front().value("samples", 0L);
  if (row.acknowledged < 0 || known - acknowledged < row.known_after - row.acknowledged) {
    row.acknowledged = acknowledged;
    row.known_after = known;
  }
}

std::vector<json> BoardSession::lines() const {
  return json_lines(content_of_file(folder_.path("out")));
}

std::vector<json> BoardSession::new_lines() const {
  std::vector<json> all = lines();
  all.erase(all.begin(), all.begin() + std::ptrdiff_t(std::min(lines_before_, all.size())));
  return all;
}

long BoardSession::acknowledged() const {
  long most = 0;
  for (const json& line : lines()) most = std::max(most, line.value("samples", 0L));
  return most;
}

bool BoardSession::reaches(double t) const {
  if (t <= 0.0) return true;
  bool running = true;
  becomes_true(
      [&] {
        running = process_->running();
        const std::vector<json> all = new_lines();
        const bool there = !all.empty() && all.back()["t"].is_number() && all.back()["t"] >= t;
        return there || !running;
      },
      options_.patience_s);
  return running;
}

bool BoardSession::falls_silent(double patience_s) const {
  const std::size_t before = new_lines().size();
  return becomes_true(
      [&] {
        const std::vector<json> all = new_lines();
        const bool silent =
            std::any_of(all.begin() + std::ptrdiff_t(before), all.end(),
                        [](const json& line) { return line.value("source", "") == "silent"; });
        return silent || !process_->running();
      },
      patience_s);
}

json BoardSession::batch(const std::vector<std::string>& files,
                         const std::vector<std::string>& arguments) const {
  std::vector<std::string> command = {options_.program, "calibrate"};
  for (const std::string& file : files) command.push_back(folder_.path(file));
  command.insert(command.end(), {"-q", "-o", folder_.path("batch.json")});
  command.insert(command.end(), arguments.begin(), arguments.end());
  std::filesystem::remove(folder_.path("batch.json"));
  run_limited(command, folder_.path(), {8.0, int(options_.patience_s), int(options_.patience_s)});
  return calibration("batch.json");
}

json BoardSession::calibration(const std::string& name) const {
  json value = json::parse(content_of_file(folder_.path(name)), nullptr, false);
  return value.is_discarded() ? json() : value;
}

void BoardSession::compare(BoardRow& row, const std::string& whole,
                           const std::vector<std::string>& parts,
                           const SensorParameters& truth) const {
  const json end = calibration("cal.json"), wanted = batch({whole});
  row.trust = board_trust(end);
  row.trust_wanted = board_trust(wanted);
  row.from_batch = board_sigmas(wanted, end);
  if (end.is_null()) return;
  row.outside = distance(end, as_calibration(truth)).outside();
  if (!parts.empty()) row.from_parts = board_sigmas(batch(parts), end);
  run_limited({options_.program, "stream", folder_.path(whole), "-q", "-o",
               folder_.path("undisturbed.json")},
              folder_.path(), {8.0, int(options_.patience_s), int(options_.patience_s)});
  row.from_stream = board_sigmas(calibration("undisturbed.json"), end);
}

void BoardSession::keep_if_bad(const BoardRow& row) const {
  if (options_.keep.empty() || (board_complaint(row).empty() && options_.only.empty())) return;
  const std::string to = fmt::format("{}/{}_{}", options_.keep, row.study, row.index);
  std::filesystem::create_directories(to);
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
    if (!entry.is_regular_file()) continue;  // a FIFO would wait for its writer
    std::filesystem::copy_file(entry.path(), std::filesystem::path(to) / entry.path().filename(),
                               std::filesystem::copy_options::overwrite_existing);
  }
}

}  // namespace magimu

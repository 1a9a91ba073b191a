// SPDX-License-Identifier: BSD-3-Clause
#include "apps/archive/reprocess_second.h"

#include <algorithm>
#include <filesystem>

#include "apps/archive/reprocess_merge.h"
#include "archive/result_file.h"
#include "archive/second_pass.h"
#include "calibration/result/calibration_json.h"

namespace magimu::apps {
namespace {

namespace fs = std::filesystem;

// s of recordings that are calibrated together where none tells enough: memory follows them.
constexpr double kMostTogether = 3600.0;

struct PoorDevice {
  std::string device;                  // path of the result that says where it is
  std::vector<FleetRecording*> poor;   // rows
  std::vector<ReprocessTask> to_find;  // one that makes `device`; none where it is there
};

class SecondPass {
 public:
  SecondPass(std::vector<FleetRecording>& rows, const std::map<std::string, ReprocessTask>& tasks,
             const std::string& folder, const ReprocessLimits& limits)
      : tasks_(tasks), folder_(folder), limits_(limits) {
    std::map<std::string, std::vector<FleetRecording*>> by_device;
    for (FleetRecording& row : rows) by_device[row.device].push_back(&row);
    for (const auto& [name, own] : by_device) look_at(own);
  }

  ReprocessRun run() {
    std::vector<ReprocessTask> first;
    for (const PoorDevice& d : devices_) {
      first.insert(first.end(), d.to_find.begin(), d.to_find.end());
    }
    ReprocessRun found = run_tasks(first, limits_);
    if (found.stopped || !found.cannot_write.empty()) return found;
    std::vector<ReprocessTask> second;
    for (const PoorDevice& d : devices_) add_tasks(d, second);
    ReprocessRun out = run_tasks(second, limits_);
    out.unfinished.insert(out.unfinished.end(), found.unfinished.begin(), found.unfinished.end());
    return out;
  }

 private:
  std::string path_of(const std::string& name) const {
    return (fs::path(folder_) / "second" / (name + ".json")).string();
  }

  bool is_done(const std::string& path) const {
    std::error_code error;
    return fs::exists(path, error) && !stopped_at_less(path, limits_.seconds, limits_.megabytes);
  }

  bool is_there(const FleetRecording& row) const {
    std::error_code error;
    const auto task = tasks_.find(row.result);
    return task != tasks_.end() && fs::exists(task->second.path, error);
  }

  void look_at(const std::vector<FleetRecording*>& rows) {
    std::vector<FleetRecording*> calibrated;
    const std::vector<DeviceRecording> all = recordings_of(rows, folder_, calibrated);
    if (!none_tells_enough(all)) return;
    PoorDevice out;
    for (std::size_t i = 0; i < all.size(); ++i) {
      // A device has as many magnetometers as its first recording.
      const bool alike =
          all[i].calibration.parameters.mag.size() == all.front().calibration.parameters.mag.size();
      if (alike && all[i].condensed && is_there(*calibrated[i])) out.poor.push_back(calibrated[i]);
    }
    if (out.poor.size() < 2) return;
    fs::create_directories(fs::path(folder_) / "second");
    std::ranges::sort(out.poor, {}, &FleetRecording::result);
    find_together(out);
    devices_.push_back(std::move(out));
  }

  void find_together(PoorDevice& out) const {
    double seconds = 0.0;
    std::vector<std::string> names;
    ReprocessTask task;
    for (const FleetRecording* row : out.poor) {
      seconds += row->duration_s;
      if (names.size() > 1 && seconds > kMostTogether) break;
      names.push_back(row->result);
      const ReprocessTask& own = tasks_.at(row->result);
      if (names.size() == 1) {
        task = own;
      } else {
        task.with.emplace_back(own.path, own.options);
      }
    }
    task.name = result_name("together", names, limits_.version);
    task.result = out.device = path_of(task.name);
    if (!is_done(task.result)) out.to_find = {task};
  }

  void add_tasks(const PoorDevice& device, std::vector<ReprocessTask>& out) const {
    std::error_code error;
    if (!fs::exists(device.device, error)) return;
    const ArchiveResult where = read_result(device.device);
    if (where.status != ResultStatus::kCalibrated) return;
    const Calibration c = calibration_from_json(where.calibration, device.device);
    if (c.trust.verdict == Verdict::kNo) return;
    for (FleetRecording* row : device.poor) {
      ReprocessTask task = tasks_.at(row->result);
      task.name = result_name(row->result, {"at", fs::path(device.device).stem().string()},
                              limits_.version);
      task.result = row->at_device = path_of(task.name);
      task.device = device.device;
      if (!is_done(task.result)) out.push_back(task);
    }
  }

  const std::map<std::string, ReprocessTask>& tasks_;
  std::string folder_;
  const ReprocessLimits& limits_;
  std::vector<PoorDevice> devices_;
};

}  // namespace

ReprocessRun second_pass(std::vector<FleetRecording>& rows,
                         const std::map<std::string, ReprocessTask>& tasks,
                         const std::string& folder, const ReprocessLimits& limits) {
  return SecondPass(rows, tasks, folder, limits).run();
}

}  // namespace magimu::apps

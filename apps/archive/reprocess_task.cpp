// SPDX-License-Identifier: BSD-3-Clause
#include "apps/archive/reprocess_task.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>
#include <ctime>
#include <deque>
#include <filesystem>
#include <fstream>
#include <thread>

#include "apps/archive/reprocess_options.h"
#include "apps/options/stop_signals.h"
#include "apps/say/progress.h"
#include "archive/inventory/found_units.h"
#include "archive/result_file.h"
#include "calibration/result/calibration_json.h"
#include "graph/numerical_error.h"
#include "recording/data/error.h"
#include "recording/files/atomic_file.h"

namespace magimu::apps {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kWritten = 0, kNotWritten = 3;  // how a child ends
constexpr int kTries = 2;                     // of what was killed from outside

std::string now_text() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

ArchiveResult refused(ResultStatus status, const std::string& reason, const std::string& remedy) {
  ArchiveResult out;
  out.status = status;
  out.reason = reason;
  out.remedy = remedy;
  return out;
}

// why: a reason, and behind a semicolon what to do, if that is known.
ArchiveResult without_fit(const std::string& why) {
  const std::size_t end = why.rfind("; ");
  return refused(
      ResultStatus::kNoFit, why.substr(0, end),
      end == std::string::npos ? "look at the recording with magimu info" : why.substr(end + 2));
}

Calibration calibration_of_task(const ReprocessTask& task, const Recording& recording,
                                const CalibrationOptions& options,
                                std::optional<CondensedRecording>& condensed) {
  if (!task.device.empty()) {
    const Calibration device =
        calibration_from_json(read_result(task.device).calibration, task.device);
    return calibrate_condensed_at(device, recording, options, condensed);
  }
  if (task.with.empty()) return calibrate_condensed(recording, options, condensed);
  std::vector<Recording> more;
  for (const auto& [path, words] : task.with) {
    more.push_back(read_with(path, parse_row_options(words), true));
    put_units_right(more.back());
  }
  std::vector<const Recording*> all = {&recording};
  for (const Recording& r : more) all.push_back(&r);
  return calibrate(all, options);
}

ArchiveResult calibrated(const ReprocessTask& task) {
  const ReprocessRowOptions row = parse_row_options(task.options);
  Recording recording = read_with(task.path, row, true);
  ArchiveResult out;
  out.found = put_units_right(recording);
  out.duration_s = recording.duration_s();
  const CalibrationOptions options = row.calibration();
  std::optional<CondensedRecording> condensed;
  Calibration c = calibration_of_task(task, recording, options, condensed);
  if (c.fit.reason == StopReason::kNotFinite) {  // calibration_without_fit()
    ArchiveResult none = without_fit(c.fit.message);
    none.found = out.found;
    none.duration_s = out.duration_s;
    return none;
  }
  check_field(c, row.place_of_field.known_field());
  out.status = ResultStatus::kCalibrated;
  out.calibration = to_json(c);
  if (condensed) out.summary = to_json(*condensed);
  return out;
}

// Whatever the recording holds, there is a result.
ArchiveResult result_of(const ReprocessTask& task) {
  try {
    return calibrated(task);
  } catch (const InputError& e) {
    std::string where;
    if (e.line > 0) where = fmt::format("line {}: ", e.line);
    return refused(ResultStatus::kRefused, where + e.problem, e.remedy);
  } catch (const NumericalError& e) {
    return without_fit(e.what());
  } catch (const std::bad_alloc&) {
    return refused(ResultStatus::kTooLarge, "there is not enough memory for it",
                   "raise --memory-limit, use fewer --jobs, or give the option --node-every");
  } catch (const std::exception& e) {
    return refused(ResultStatus::kCrashed, std::string("internal error: ") + e.what(),
                   "this is a defect of magimu: please report it with the recording");
  }
}

void write_result(const ReprocessTask& task, ArchiveResult result, const ReprocessLimits& limits) {
  result.limit_s = limits.seconds;
  result.limit_megabytes = limits.megabytes;
  write_atomically(task.result,
                   result_json(task.name, result,
                               {limits.version, task.path,
                                fmt::format("{}", fmt::join(task.options, " ")), now_text()}));
}

// Of this process, bytes.
rlim_t address_space() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return rlim_t(pages) * rlim_t(::sysconf(_SC_PAGESIZE));
}

[[noreturn]] void child_process(const ReprocessTask& task, const ReprocessLimits& limits,
                                int message, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // with the parent nobody waits for this any more
  if (::getppid() != parent) ::_exit(kNotWritten);
  // Ctrl-C reaches all processes of a terminal; the parent ends this one.
  ::signal(SIGINT, SIG_IGN);
  ::signal(SIGTERM, SIG_DFL);
  if (limits.megabytes > 0.0) {
    // What the program has mapped so far is not the recording's.
    const rlim_t bytes = address_space() + rlim_t(limits.megabytes * 1048576.0);
    const rlimit limit{bytes, bytes};
    ::setrlimit(RLIMIT_AS, &limit);
  }
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  try {
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                      std::size_t(limits.threads));
    write_result(task, result_of(task), limits);
    ::_exit(kWritten);
  } catch (const std::exception& e) {
    const ssize_t n = ::write(message, e.what(), std::strlen(e.what()));
    ::_exit(n >= 0 ? kNotWritten : kNotWritten + 1);
  }
}

struct Running {
  pid_t id = -1;
  int message = -1;
  std::size_t task = 0;
  Clock::time_point begin;
  bool stopped = false;  // by us, for its time
};

// Of all threads of a process.
double processor_seconds(pid_t id) {
  clockid_t clock{};
  timespec used{};
  if (::clock_getcpuclockid(id, &clock) != 0 || ::clock_gettime(clock, &used) != 0) return 0.0;
  return double(used.tv_sec) + 1e-9 * double(used.tv_nsec);
}

class Pool {
 public:
  Pool(const std::vector<ReprocessTask>& tasks, const ReprocessLimits& limits)
      : tasks_(tasks), limits_(limits), tries_(tasks.size(), 0), bar_(!limits.quiet) {
    for (std::size_t i = 0; i < tasks.size(); ++i) waiting_.push_back(i);
  }
  ~Pool() {
    for (const Running& r : running_) {
      ::kill(r.id, SIGKILL);
      ::waitpid(r.id, nullptr, 0);
      ::close(r.message);
    }
  }

  ReprocessRun run() {
    while (!running_.empty() || (!waiting_.empty() && out_.cannot_write.empty())) {
      while (!waiting_.empty() && out_.cannot_write.empty() &&
             int(running_.size()) < limits_.jobs) {
        start(waiting_.front());
        waiting_.pop_front();
      }
      look();
      if (stop_requested()) {
        out_.stopped = !running_.empty() || !waiting_.empty();
        break;
      }
      if (!tasks_.empty()) {
        bar_(fmt::format("{} of {} recordings", out_.done, tasks_.size()),
             double(out_.done) / double(tasks_.size()));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return out_;
  }

 private:
  void start(std::size_t task) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) {
      throw std::runtime_error(std::string("no pipe: ") + std::strerror(errno));
    }
    std::fflush(nullptr);
    const pid_t parent = ::getpid();
    const pid_t id = ::fork();
    if (id < 0) throw std::runtime_error(std::string("no process: ") + std::strerror(errno));
    if (id == 0) {
      ::close(ends[0]);
      child_process(tasks_[task], limits_, ends[1], parent);
    }
    ::close(ends[1]);
    ++tries_[task];
    running_.push_back({id, ends[0], task, Clock::now(), false});
  }

  void look() {
    for (std::size_t i = 0; i < running_.size();) {
      Running& r = running_[i];
      int status = 0;
      if (::waitpid(r.id, &status, WNOHANG) == 0) {
        // Of a busy machine's clock a result would depend on what else runs on it.
        constexpr double kHanging = 10.0;  // times the limit by the clock: it waits for something
        const std::chrono::duration<double> since = Clock::now() - r.begin;
        const bool too_long =
            since.count() > limits_.seconds && (processor_seconds(r.id) > limits_.seconds ||
                                                since.count() > kHanging * limits_.seconds);
        if (too_long && !r.stopped) {
          r.stopped = true;
          ::kill(r.id, SIGKILL);
        }
        ++i;
        continue;
      }
      const Running ended = r;
      running_.erase(running_.begin() + std::ptrdiff_t(i));
      finish(ended, status);
      ::close(ended.message);
    }
  }

  void finish(const Running& r, int status) {
    const ReprocessTask& task = tasks_[r.task];
    if (WIFEXITED(status) && WEXITSTATUS(status) == kWritten) {
      ++out_.done;
      return;
    }
    if (WIFEXITED(status) && WEXITSTATUS(status) == kNotWritten) {
      char text[1000];
      const ssize_t n = ::read(r.message, text, sizeof text);
      out_.cannot_write = n > 0 ? std::string(text, std::size_t(n)) : "a result cannot be written";
      return;
    }
    if (r.stopped) {
      write_instead(task, refused(ResultStatus::kTooLong,
                                  fmt::format("it took longer than {:.0f} s", limits_.seconds),
                                  "raise --time-limit, or give it the option --node-every"));
    } else if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) {
      // By a person, a scheduler, or the system when it runs out of memory: not the recording's
      // fault for sure.
      if (tries_[r.task] < kTries) {
        waiting_.push_back(r.task);
      } else {
        out_.unfinished.push_back(task.shown);
      }
    } else {
      const std::string how =
          WIFSIGNALED(status)
              ? fmt::format("signal {} ({})", WTERMSIG(status), ::strsignal(WTERMSIG(status)))
              : fmt::format("exit code {}", WEXITSTATUS(status));
      write_instead(
          task, refused(ResultStatus::kCrashed, "the program ended within this recording: " + how,
                        "this is a defect of magimu: please report it with the "
                        "recording"));
    }
  }

  void write_instead(const ReprocessTask& task, const ArchiveResult& result) {
    try {
      write_result(task, result, limits_);
      ++out_.done;
    } catch (const InputError& e) {
      out_.cannot_write = e.what();
    }
  }

  const std::vector<ReprocessTask>& tasks_;
  const ReprocessLimits& limits_;
  std::vector<int> tries_;
  std::deque<std::size_t> waiting_;
  std::vector<Running> running_;
  ReprocessRun out_;
  ProgressBar bar_;
};

}  // namespace

ReprocessRun run_tasks(const std::vector<ReprocessTask>& tasks, const ReprocessLimits& limits) {
  return Pool(tasks, limits).run();
}

}  // namespace magimu::apps

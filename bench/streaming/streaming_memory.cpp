// SPDX-License-Identifier: BSD-3-Clause
#include "bench/streaming/streaming_memory.h"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <tuple>

#include "bench/streamed.h"
#include "graph/bytes.h"
#include "study/error_statistics.h"

namespace magimu {
namespace {

constexpr long kFirst = 10000, kEvery = 16;  // as StreamSession keeps the estimate

// Of this process, MB: "VmRSS" now, "VmHWM" at most.
double megabytes(const std::string& what) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(what)) return 1024e-6 * std::stod(line.substr(what.size() + 1));
  }
  return NAN;
}

double now_s() {
  const auto t = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(t).count();
}
// Of this thread alone.
double thread_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

template <class Body>
void in_a_process(const Body& body) {
  std::fflush(stdout);
  const pid_t child = ::fork();
  if (child == 0) {
    try {
      body();
    } catch (const std::exception& error) {
      fmt::print("failed: {}\n", error.what());
    }
    std::fflush(stdout);
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  if (status != 0) fmt::print("failed: it was ended by signal {}\n", WTERMSIG(status));
}

using Row = std::array<double, 10>;  // t, acc, gyr, mag; not a number: none

class Samples {
 public:
  explicit Samples(const std::string& path) : in_(path, std::ios::binary) {}
  std::optional<StreamSample> operator()() {
    Row row;
    if (!in_.read(reinterpret_cast<char*>(row.data()), sizeof row)) return std::nullopt;
    ++read_;
    StreamSample s;
    s.t = row[0];
    const auto vector = [&row](std::size_t at) -> std::optional<Vector3> {
      if (std::isnan(row[at])) return std::nullopt;
      return Vector3(row[at], row[at + 1], row[at + 2]);
    };
    s.acc = vector(1);
    s.gyr = vector(4);
    s.mag = {vector(7)};
    return s;
  }
  long read() const { return read_; }

 private:
  std::ifstream in_;
  long read_ = 0;
};

void write_samples(const SimulationOptions& simulation, const std::string& path) {
  const Simulation s = simulate(simulation);
  std::ofstream out(path, std::ios::binary);
  for (const StreamSample& sample : samples_of(s.recording)) {
    Row row;
    row.fill(NAN);
    row[0] = sample.t;
    const auto put = [&row](const std::optional<Vector3>& v, std::size_t at) {
      for (int i = 0; v && i < 3; ++i) row[at + std::size_t(i)] = (*v)[i];
    };
    put(sample.acc, 1);
    put(sample.gyr, 4);
    put(sample.mag[0], 7);
    out.write(reinterpret_cast<const char*>(row.data()), sizeof row);
  }
}

void write_result(const Calibration& c, const std::string& path) {
  std::ofstream out(path, std::ios::binary);
  ByteWriter bytes(out);
  bytes.put(in_calibration_order(c));
  bytes.put(VectorXd(c.covariance_model.diagonal().cwiseSqrt()));
  bytes.put(VectorXd(c.covariance.diagonal().cwiseSqrt()));
  for (const ResidualSummary& r : c.residuals) {
    for (const double x : {r.rms, r.lag1, r.rms_unit}) bytes.put(x);
  }
  bytes.finish();
}

void compare(const std::string& what, const std::string& a, const std::string& b) {
  std::ifstream in_a(a, std::ios::binary), in_b(b, std::ios::binary);
  if (!is_whole(in_a) || !is_whole(in_b)) return;
  ByteReader one(in_a), other(in_b);
  VectorXd x, y, sigma_x, sigma_y, robust_x, robust_y;
  one.get(x), one.get(sigma_x), one.get(robust_x);
  other.get(y), other.get(sigma_y), other.get(robust_y);
  const auto n = y.size();
  const auto change = [n](const VectorXd& p, const VectorXd& q) {
    return 100.0 * (p.head(n).cwiseQuotient(q.head(n)).array() - 1.0).abs().maxCoeff();
  };
  fmt::print(
      "{}: {:.2g} sigma at the most; sigmas differ by up to {:.2g} %, robust ones by {:.2g} %",
      what, (x - y).cwiseAbs().cwiseQuotient(sigma_y.head(n)).maxCoeff(), change(sigma_x, sigma_y),
      change(robust_x, robust_y));
  double largest = 0.0;
  for (int i = 0; i < 9; ++i) {
    largest = std::max(largest, std::abs(one.get<double>() - other.get<double>()));
  }
  fmt::print(", residual statistics by {:.2g}\n", largest);
}

void finish(StreamingCalibration& stream, const std::string& result) {
  const double begin = now_s(), before = megabytes("VmHWM:");
  const Calibration c = stream.finish();
  fmt::print(
      "finish() {:.1f} s, {} nodes, at most {:.0f} MB before, {:.0f} MB after; trust {}; {}\n",
      now_s() - begin, c.nodes, before, megabytes("VmHWM:"), to_string(c.trust.verdict),
      c.fit.message);
  write_result(c, result);
}

// The whole stream, its estimate kept on the way as `magimu stream --state` does.
void stream_all(const std::string& samples, const StreamingOptions& options,
                const std::string& estimate, const std::string& result) {
  ::mallopt(M_MMAP_THRESHOLD, 1 << 20);  // as `magimu stream`
  StreamingCalibration stream(1, options);
  Samples next(samples);
  std::vector<std::pair<double, double>> updates;
  long keep_at = kFirst;
  double report = 0.0, longest = 0.0;
  const double begin = now_s();
  while (const auto sample = next()) {
    const double start = thread_s();
    const auto update = stream.add(*sample);
    if (!update) continue;
    if (update->theta) updates.emplace_back(update->t, 1e6 * (thread_s() - start));
    if (update->t >= report) {
      fmt::print("at {:5.0f} s: {:.0f} MB now, {:.0f} MB at most\n", update->t, megabytes("VmRSS:"),
                 megabytes("VmHWM:"));
      std::fflush(stdout);
      report += 900.0;
    }
    if (estimate.empty() || next.read() < keep_at) continue;
    const double saving = now_s();
    std::ofstream out(estimate, std::ios::binary | std::ios::trunc);
    stream.save(out);
    longest = std::max(longest, now_s() - saving);
    keep_at = next.read() + next.read() / kEvery;
  }
  const double took = now_s() - begin;
  fmt::print("{} samples in {:.1f} s: {:.0f} a second\n", next.read(), took,
             double(next.read()) / took);
  if (!updates.empty()) print_latency(updates);
  if (std::filesystem::exists(estimate)) {
    fmt::print("keeping the estimate: {:.2f} s at most, {:.0f} MB in the end\n", longest,
               1e-6 * double(std::filesystem::file_size(estimate)));
  }
  finish(stream, result);
}

void restart(const std::string& samples, const StreamingOptions& options,
             const std::string& estimate, const std::string& result) {
  ::mallopt(M_MMAP_THRESHOLD, 1 << 20);
  const double begin = now_s();
  StreamingCalibration stream(1, options);
  Samples next(samples);
  std::ifstream kept(estimate, std::ios::binary);
  const bool taken = stream.take_up(kept, [&] { return next(); });
  const double took = now_s() - begin;
  const long known = next.read();
  if (taken) {
    while (const auto sample = next()) stream.add(*sample);
  }
  fmt::print("restart: {} {} samples after {:.2f} s, all {} after {:.2f} s, at most {:.0f} MB\n",
             taken ? "has" : "REFUSED at", known, took, next.read(), now_s() - begin,
             megabytes("VmHWM:"));
  finish(stream, result);
}

}  // namespace

void print_latency(const std::vector<std::pair<double, double>>& updates) {
  const double end = updates.back().first;
  for (const auto& [name, from, to] : {std::tuple{"first ten minutes", 0.0, 600.0},
                                       std::tuple{"last ten minutes", end - 600.0, end + 1.0},
                                       std::tuple{"all", 0.0, end + 1.0}}) {
    std::vector<double> us;
    for (const auto& [t, x] : updates) {
      if (t >= from && t < to) us.push_back(x);
    }
    std::sort(us.begin(), us.end());
    const auto at = [&](double q) { return us[std::size_t(q * double(us.size() - 1))]; };
    fmt::print("{:18} {:5} updates: median {:.0f} us, 99 % {:.0f} us, largest {:.0f} us\n", name,
               us.size(), at(0.5), at(0.99), us.back());
  }
}

void measure_memory(const SimulationOptions& simulation, const StreamingOptions& options,
                    const std::string& folder, bool batch) {
  const std::string samples = folder + "/samples", estimate = folder + "/estimate",
                    streamed = folder + "/streamed", restarted = folder + "/restarted",
                    whole = folder + "/whole";
  in_a_process([&] { write_samples(simulation, samples); });
  in_a_process([&] { stream_all(samples, options, estimate, streamed); });
  in_a_process([&] { restart(samples, options, estimate, restarted); });
  compare("restarted against uninterrupted", restarted, streamed);
  if (!batch) return;
  StreamingOptions at_once = options;
  at_once.long_stream = std::numeric_limits<int>::max();
  fmt::print("all samples at once:\n");
  in_a_process([&] { stream_all(samples, at_once, "", whole); });
  compare("streamed against all at once", streamed, whole);
}

}  // namespace magimu

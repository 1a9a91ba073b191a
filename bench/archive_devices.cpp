// SPDX-License-Identifier: BSD-3-Clause
#include "bench/archive_devices.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <numeric>

#include "archive/second_pass.h"
#include "calibration/condensed_recording.h"
#include "sim/draws/random.h"

namespace magimu {
namespace {

CalibrationOptions archive_options(const ArchiveMade& archive = {}) {
  CalibrationOptions out;
  if (archive.given_noise) out.noise = kPaperNoise;
  out.gravity = kPaperGravity;
  out.motion = MotionModel::kRotation;
  return out;
}

DeviceRecording calibrated_recording(const Recording& recording, const std::string& name,
                                     const ArchiveMade& archive,
                                     const Calibration* device = nullptr) {
  DeviceRecording out;
  out.name = out.shown = name;
  const CalibrationOptions options = archive_options(archive);
  out.calibration = device == nullptr
                        ? calibrate_condensed(recording, options, out.condensed)
                        : calibrate_condensed_at(*device, recording, options, out.condensed);
  for (const Check& c : out.calibration.checks) {
    if (c.name == "halves" && c.status != CheckStatus::kOk) out.widened = std::max(1.0, c.value);
  }
  return out;
}

// As `magimu reprocess` does.
void pass_again(const std::vector<const Recording*>& samples, const ArchiveMade& archive,
                std::vector<DeviceRecording>& all) {
  if (!none_tells_enough(all)) return;
  const Calibration device = calibrate(samples, archive_options(archive));
  if (device.trust.verdict == Verdict::kNo) return;
  for (std::size_t i = 0; i < all.size(); ++i) {
    take_second_pass(all[i], calibrated_recording(*samples[i], all[i].name, archive, &device));
  }
}

std::vector<const Recording*> pointers_to(const std::vector<Recording>& recordings) {
  std::vector<const Recording*> out;
  for (const Recording& r : recordings) out.push_back(&r);
  return out;
}

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

VectorXd truth_vector(const std::vector<std::string>& order, const SensorParameters& p,
                      double dip_deg) {
  VectorXd out(Eigen::Index(order.size()));
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::string& name = order[i];
    const auto index = [&](std::size_t from_end) {
      return Eigen::Index(name[name.size() - from_end] - '0');
    };
    double& x = out[Eigen::Index(i)];
    if (name.starts_with("accelerometer"))
      x = p.acc_bias[index(2)];
    else if (name.starts_with("gyroscope"))
      x = p.gyr_bias[index(2)];
    else if (name == "field.dip_deg")
      x = dip_deg;
    else if (name.find("distortion") != std::string::npos)
      x = p.mag[0].distortion(index(5), index(2));
    else
      x = p.mag[0].bias[index(2)];
  }
  return out;
}

}  // namespace

Simulation archive_recording(const SensorParameters& device, std::uint64_t seed, double seconds) {
  SimulationOptions sim;
  sim.motion = SimulatedMotion::kHand;
  sim.seed = seed;
  sim.rate_hz = 40.0;
  sim.duration_s = seconds;
  return simulate_device(sim, device);
}

NeesReport device_nees(const ArchiveMade& archive) {
  NeesReport out;
  const std::pair<const char*, std::pair<int, int>> groups[] = {{"accelerometer's bias", {0, 3}},
                                                                {"gyroscope's bias", {3, 3}},
                                                                {"distortion", {6, 9}},
                                                                {"hard iron", {15, 3}},
                                                                {"dip", {18, 1}}};
  for (const auto& [name, of] : groups) out.groups.push_back({name, {}});
  for (int d = 0; d < archive.devices; ++d) {
    const SensorParameters device = draw_parameters(std::uint64_t(1000 + d), 1);
    std::vector<DeviceRecording> all;
    std::vector<Recording> samples;
    double dip = 0.0;
    for (int r = 0; r < archive.recordings; ++r) {
      const Simulation s =
          archive_recording(device, std::uint64_t(10000 + 100 * d + r), archive.seconds);
      dip = s.truth.parameters.dip_rad / kDegree;
      out.condensed_s += seconds_of([&] {
        all.push_back(calibrated_recording(s.recording, fmt::format("{:03}", r), archive));
      });
      if (d == 0)
        out.calibrate_s += seconds_of([&] { calibrate(s.recording, archive_options(archive)); });
      samples.push_back(s.recording);
    }
    out.condensed_s += seconds_of([&] { pass_again(pointers_to(samples), archive, all); });
    if (d == 0) out.calibrate_s *= archive.devices;
    const Device made = make_device("d", std::move(all));
    out.flagged += !made.history.changes.empty();
    if (!made.calibration || made.calibration->order.size() != 19) continue;
    const Calibration& c = *made.calibration;
    const VectorXd error = truth_vector(c.order, c.parameters, c.parameters.dip_rad / kDegree) -
                           truth_vector(c.order, device, dip);
    out.nees.push_back(error.dot(c.covariance.llt().solve(error)) / 19.0);
    for (std::size_t g = 0; g < out.groups.size(); ++g) {
      const auto [first, size] = groups[g].second;
      const VectorXd own = error.segment(first, size);
      const MatrixXd V = c.covariance.block(first, first, size, size);
      out.groups[g].second.push_back(own.dot(V.llt().solve(own)) / size);
    }
  }
  return out;
}

std::vector<double> distances_from_together(const ArchiveMade& archive) {
  std::vector<double> out;
  for (int d = 0; d < archive.devices; ++d) {
    const SensorParameters device = draw_parameters(std::uint64_t(1000 + d), 1);
    std::vector<Recording> samples;
    std::vector<DeviceRecording> all;
    for (int r = 0; r < archive.recordings; ++r) {
      samples.push_back(
          archive_recording(device, std::uint64_t(10000 + 100 * d + r), archive.seconds).recording);
      all.push_back(calibrated_recording(samples.back(), fmt::format("{:03}", r), archive));
    }
    const std::vector<const Recording*> given = pointers_to(samples);
    pass_again(given, archive, all);
    CalibrationOptions options = archive_options(archive);
    options.prior = PriorKind::kNone;  // what is usual of parts does not enter a device's sum
    const Calibration together = calibrate(given, options);
    const Device made = make_device("d", std::move(all));
    if (!made.calibration) continue;
    const VectorXd x = truth_vector(made.order, together.parameters, 0.0);
    double farthest = 0.0;
    for (Eigen::Index i = 0; i < 18; ++i) {
      const double sigma = together.sigma_model(made.order[std::size_t(i)]);
      farthest = std::max(farthest, std::abs(made.joint[i] - x[i]) / sigma);
    }
    out.push_back(farthest);
  }
  return out;
}

std::string NeesReport::text() const {
  const auto mean = [](const std::vector<double>& x) {
    return std::accumulate(x.begin(), x.end(), 0.0) / double(x.size());
  };
  std::string by_group;
  for (const auto& [name, of] : groups) by_group += fmt::format(", {} {:.3f}", name, mean(of));
  return fmt::format(
      "NEES/19 of {} devices: {:.3f} (0.87 to 1.14 is asked){}; {} flagged without cause; {:.2f} "
      "times the cost of calibrate\n",
      nees.size(), mean(nees), by_group, flagged, condensed_s / calibrate_s);
}

ChangesReport device_changes(int devices, int recordings, double sigmas, bool drift) {
  // Ten real summaries serve as what recordings know; optima are drawn about each device's truth.
  static const std::vector<DeviceRecording> known = [] {
    std::vector<DeviceRecording> all;
    for (std::uint64_t i = 0; i < 10; ++i) {
      const Simulation s = archive_recording(draw_parameters(77, 1), 500 + i, 60.0);
      all.push_back(calibrated_recording(s.recording, "r", {}));
    }
    return all;
  }();
  const SensorParameters truth = draw_parameters(77, 1);
  ChangesReport out;
  out.devices = devices;
  for (int d = 0; d < devices; ++d) {
    RandomStream random(std::uint64_t(d) + (drift ? 5000 : 0), RandomPurpose::kEffectSize,
                        std::uint64_t(sigmas * 16));
    const bool changes = d % 2 == 0;
    const int at = 1 + random.index(recordings - 1);
    const Vector3 direction = random.normal3().normalized();
    std::vector<DeviceRecording> all;
    for (int r = 0; r < recordings; ++r) {
      DeviceRecording own = known[std::size_t(random.index(int(known.size())))];
      CondensedRecording& c = *own.condensed;
      VectorXd x = truth_vector(c.order, truth, own.calibration.parameters.dip_rad / kDegree);
      const MatrixXd V = (c.R.transpose() * c.R).inverse();
      if (changes && !drift && r >= at) {
        const double sigma = std::sqrt(direction.dot(V.block<3, 3>(15, 15) * direction));
        x.segment<3>(15) += sigmas * sigma * direction;
      }
      if (changes && drift) {
        const VectorXd D = x.segment<9>(6);
        const double sigma = 1.0 / std::sqrt(D.dot(V.block<9, 9>(6, 6).llt().solve(D)));
        x.segment<9>(6) += sigmas * sigma * (double(r) / (recordings - 1) - 0.5) * D;
      }
      // |R (u - x) + e|^2 with e white: an optimum drawn about x.
      VectorXd e(x.size());
      for (double& v : e) v = random.normal();
      c.d = c.R * (c.at - x) + e;
      own.name = own.shown = fmt::format("{:03}", r);
      own.calibration.undetermined.clear();
      all.push_back(std::move(own));
    }
    const Device device = make_device("d", std::move(all));
    const auto& found = device.history.changes;
    if (!changes) {
      out.false_alarms += !found.empty();
      continue;
    }
    ++out.changed;
    out.named_step += std::ranges::any_of(found, [&](const FoundChange& f) {
      const std::string& group = device.groups[f.change.group].name;
      return drift ? f.change.kind != ChangeKind::kStep && group.find("distortion") != group.npos
                   : f.change.kind == ChangeKind::kStep && group.ends_with("].bias");
    });
    out.dated += std::ranges::any_of(found, [&](const FoundChange& f) {
      return f.change.kind == ChangeKind::kStep && int(f.change.at) == at;
    });
  }
  return out;
}

}  // namespace magimu

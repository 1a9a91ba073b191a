// SPDX-License-Identifier: BSD-3-Clause
// From the fields of a BROAD file to a recording: orientation of the arrays, time base, truth.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "recording/arrays/arrays.h"
#include "recording/arrays/broad_fields.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"

namespace magimu {
namespace {

// In m/s^2, rad/s and uT alike. Damaged bytes that pass as numbers are mostly far beyond it.
constexpr double kBeyondAnySensor = 1e6;

constexpr const char* kOtherFile = "give another copy of the file, or convert it to CSV";

// A field as N samples of `components` numbers, whichever way round it lies in the file.
class Samples {
 public:
  Samples(const BroadFile& file, const std::string& name, std::size_t components)
      : field_(file.read(name)) {
    // With so few samples one could not tell the two ways apart; nor calibrate anything.
    if (std::max(field_.rows, field_.columns) < 5) {
      throw InputError(file.path, 0, 0, fmt::format("{} has fewer than 5 samples", name),
                       "give a longer recording");
    }
    if (field_.columns != components && field_.rows == components) {
      size_ = field_.columns;
      component_stride_ = size_;
    } else if (field_.columns == components) {
      size_ = field_.rows;
      sample_stride_ = components;
    } else {
      throw InputError(file.path, 0, 0,
                       fmt::format("{} is {} x {}, it should be N x {}", name, field_.rows,
                                   field_.columns, components),
                       kOtherFile);
    }
  }

  std::size_t size() const { return size_; }
  double operator()(std::size_t k, std::size_t i) const {
    return field_.values[k * sample_stride_ + i * component_stride_];
  }
  Vector3 vector(std::size_t k) const { return {(*this)(k, 0), (*this)(k, 1), (*this)(k, 2)}; }

 private:
  BroadField field_;
  std::size_t size_ = 0, sample_stride_ = 1, component_stride_ = 1;
};

bool has(const BroadFile& file, const std::string& name) {
  return std::ranges::find(file.names, name) != file.names.end();
}

bool is_broad(const BroadFile& file) {
  return has(file, "imu_acc") || has(file, "imu_gyr") || has(file, "imu_mag");
}

// Options for CSV would go unheard.
void refuse_options(const std::string& path, const CsvOptions& options) {
  if (options.columns.empty() && !options.time_unit && !options.acc_unit && !options.gyr_unit &&
      !options.mag_unit && !options.rate_hz) {
    return;
  }
  throw InputError(path, 0, 0,
                   "this is an HDF5 or MAT file of the BROAD data set, whose names and units are "
                   "fixed (m/s^2, rad/s, uT)",
                   "give no mapping of columns (--map), no units (--unit) and no --rate with it");
}

void check_fields(const BroadFile& file) {
  std::string there;
  for (const std::string& name : file.names) {
    there += (there.empty() ? "" : ", ") + quoted_text(name);
  }
  for (const char* name : {"imu_acc", "imu_gyr", "imu_mag", "sampling_rate"}) {
    if (has(file, name)) continue;
    throw InputError(file.path, 0, 0,
                     fmt::format("there is no field {}; the fields there are: {}", name,
                                 there.empty() ? "none" : there),
                     "give a recording of the BROAD data set, or convert this one to CSV");
  }
}

double sampling_rate(const BroadFile& file) {
  const BroadField field = file.read("sampling_rate");
  if (field.values.size() == 1 && std::isfinite(field.values[0]) && field.values[0] > 0.0) {
    return field.values[0];
  }
  throw InputError(file.path, 0, 0, "sampling_rate is not one positive number", kOtherFile);
}

// As many samples as the accelerometer has.
Samples read_samples(const BroadFile& file, const std::string& name, std::size_t components,
                     std::size_t expected) {
  Samples samples(file, name, components);
  if (samples.size() == expected) return samples;
  throw InputError(
      file.path, 0, 0,
      fmt::format("{} has {} samples, but imu_acc has {}", name, samples.size(), expected),
      kOtherFile);
}

VectorSeries finite_samples(const Samples& samples, const std::vector<double>& t,
                            const std::string& path, const std::string& name,
                            std::vector<std::string>& notes) {
  VectorSeries series;
  series.t.reserve(t.size());
  series.v.reserve(t.size());
  for (std::size_t k = 0; k < t.size(); ++k) {
    const Vector3 v = samples.vector(k);
    if (!v.allFinite()) continue;
    if (v.cwiseAbs().maxCoeff() > kBeyondAnySensor) {
      throw InputError(path, 0, 0, fmt::format("{} holds numbers that no sensor measures", name),
                       fmt::format("the file is damaged: {}", kOtherFile));
    }
    series.push_back(t[k], v);
  }
  if (series.empty()) {
    throw InputError(path, 0, 0, fmt::format("no sample of {} is a finite number", name),
                     kOtherFile);
  }
  if (const std::size_t lost = t.size() - series.size(); lost > 0) {
    notes.push_back(fmt::format("{} samples of {} are left out: they are not finite", lost, name));
  }
  return series;
}

MotionTruth read_truth(const BroadFile& file, const std::vector<double>& t) {
  MotionTruth truth;
  truth.t = t;
  if (has(file, "opt_pos")) {
    const Samples positions = read_samples(file, "opt_pos", 3, t.size());
    for (std::size_t k = 0; k < t.size(); ++k) truth.position.push_back(positions.vector(k));
  }
  if (has(file, "movement")) {
    const Samples movement = read_samples(file, "movement", 1, t.size());
    for (std::size_t k = 0; k < t.size(); ++k) truth.moving.push_back(movement(k, 0) != 0.0);
  }
  const Samples quaternions = read_samples(file, "opt_quat", 4, t.size());
  for (std::size_t k = 0; k < t.size(); ++k) {
    const Vector4 q(quaternions(k, 0), quaternions(k, 1), quaternions(k, 2), quaternions(k, 3));
    const bool turned = std::abs(q.norm() - 1.0) < 0.1;  // false for NaN, too
    const bool valid = turned && (truth.position.empty() || truth.position[k].allFinite());
    truth.valid.push_back(valid);
    truth.nRb.push_back(valid ? Rot3::from_quaternion(q) : Rot3());
  }
  return truth;
}

}  // namespace

Recording recording_from_broad(const BroadFile& file, const CsvOptions& options) {
  if (!is_broad(file)) return recording_from_arrays(file, options);
  refuse_options(file.path, options);
  check_fields(file);
  const double rate_hz = sampling_rate(file);
  const Samples acc(file, "imu_acc", 3);
  const Samples gyr = read_samples(file, "imu_gyr", 3, acc.size());
  const Samples mag = read_samples(file, "imu_mag", 3, acc.size());
  std::vector<double> t(acc.size());
  for (std::size_t k = 0; k < t.size(); ++k) t[k] = static_cast<double>(k) / rate_hz;

  Recording recording;
  recording.name = std::filesystem::path(file.path).filename().string();
  recording.acc = finite_samples(acc, t, file.path, "imu_acc", recording.notes);
  recording.gyr = finite_samples(gyr, t, file.path, "imu_gyr", recording.notes);
  recording.mag.push_back(finite_samples(mag, t, file.path, "imu_mag", recording.notes));
  recording.mag_names.emplace_back("mag");
  if (has(file, "opt_quat")) recording.truth = read_truth(file, t);
  // The set does not say so, but its rates agree best with the differentiated optical orientation
  // when each is taken for the mean about its own time (bench/README.md).
  convert_gyro_interval(recording, GyroInterval::kCentred);
  recording.notes.emplace_back("gyroscope samples are taken as means centred on their times");
  return recording;
}

BroadRoom::BroadRoom(const std::string& path) : path_(path) {
  // Numbers with two bits of noise each pack to no less. The constant (8 MB) is for small files of
  // repeated numbers.
  std::error_code no_file;
  const auto size = std::filesystem::file_size(path, no_file);
  left_ = 1'000'000 + (no_file ? 0 : 4 * static_cast<std::size_t>(size));
}

void BroadRoom::refuse(const std::string& name, const std::string& claim) const {
  throw InputError(path_, 0, 0,
                   fmt::format("{} claims {}, more than the file can hold", name, claim),
                   fmt::format("the file is damaged: {}", kOtherFile));
}

BroadField BroadRoom::field(const std::string& name, const std::vector<std::size_t>& dimensions) {
  BroadField field{1, 1, {}};
  if (!dimensions.empty()) field.rows = dimensions[0];
  if (dimensions.size() > 1) field.columns = dimensions[1];
  if (dimensions.size() > 2) {
    throw InputError(
        path_, 0, 0,
        fmt::format("{} has {} dimensions, it should have one or two", name, dimensions.size()),
        kOtherFile);
  }
  if (field.columns > 0 && field.rows > left_ / field.columns) {
    refuse(name, fmt::format("{} x {} numbers", field.rows, field.columns));
  }
  left_ -= field.rows * field.columns;
  field.values.resize(field.rows * field.columns);
  return field;
}

}  // namespace magimu

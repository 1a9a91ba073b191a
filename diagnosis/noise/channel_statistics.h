// SPDX-License-Identifier: BSD-3-Clause
// Statistics of what a fit leaves of one sensor, by which measurement and simulation are compared:
// of the whole (size, correlation, tails, ...), of pieces of each recording, and of its dependence
// on direction and rate, in the whole and in each piece. An error that begins, ends or changes in
// mid-recording shows in the pieces, however well the parameters fit the mean of it.
//
// All but the size are in units of the residual's own root mean square: the density of the noise
// was estimated from the same data as a rule.
#pragma once

#include <string>
#include <vector>

#include "calibration/fit/optimum.h"
#include "factors/effects/effect.h"

namespace magimu {

inline constexpr int kPiecesOfRecording = 6;  // of each recording: 10 to 30 s as a rule

struct ChannelStatistic {
  // How a value is distributed under noise, and which transform makes it normal.
  enum class Shape { kNormal, kRms, kCorrelation, kRatio, kTails };
  std::string name = {};  // "size", "mean of x", "x against the field's y", ...
  Shape shape = Shape::kNormal;
  double begin_s = 0.0, end_s = 0.0;  // of a piece; both 0: of everything
  std::string recording = {};         // of a piece
};

class ChannelStatistics {
 public:
  // The rows of one sensor (magnetometer `index` of an array), in the order of time.
  ChannelStatistics(const Optimum& at, const std::vector<const Recording*>& recordings,
                    Sensor sensor, int index);

  Sensor sensor() const { return sensor_; }
  const std::string& name() const { return name_; }  // "acc", "gyr", "mag", "mag2", ...
  const std::vector<ChannelStatistic>& list() const { return list_; }
  // First rows of the sensor's residuals, three each, the node and the recording of each.
  const std::vector<int>& rows() const { return row_; }
  const std::vector<int>& nodes() const { return node_; }
  const std::vector<int>& recording_of_rows() const { return recording_; }

  // Of these residuals, transformed so that they are normal under noise.
  VectorXd values(const VectorXd& residual) const;
  // The statistic itself, from the transformed value.
  double shown(std::size_t statistic, double value) const;

 private:
  static constexpr int kFeatures = 7;  // 1, a direction, the rate
  using Features = Vec<double, kFeatures>;
  struct Piece {
    int recording = 0;
    double begin_s = 0.0, end_s = 0.0;
    int count = 0;
    Features squares = Features::Zero();
  };

  void find_rows(const Optimum& at, int index);
  void add_features(const Optimum& at, const std::vector<const Recording*>& recordings);
  void make_list(const std::vector<const Recording*>& recordings);
  double transformed(ChannelStatistic::Shape shape, double value) const;

  Sensor sensor_;
  std::string name_;
  std::vector<int> row_, node_, recording_, piece_, second_;
  int seconds_ = 0;
  std::vector<double> time_;  // of the recording, 0 to 1
  std::vector<Features> features_;
  std::vector<Piece> pieces_;  // the last one: everything
  std::vector<ChannelStatistic> list_;
};

}  // namespace magimu

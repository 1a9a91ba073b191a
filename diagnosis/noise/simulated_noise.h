// SPDX-License-Identifier: BSD-3-Clause
// Noise of a fitted model's rows, with the colour and the outliers that were found in its samples.
#pragma once

#include <random>

#include "diagnosis/noise/channel_statistics.h"
#include "diagnosis/result/diagnosis.h"

namespace magimu {

class SimulatedNoise {
 public:
  // samples: of the sensor as recorded, about each node.
  struct OfSensor {
    const ChannelStatistics* sensor = nullptr;
    int samples = 1;
    double rho = 0.0;         // of neighbouring samples
    double eps = 0.0, K = 0;  // outliers
    double scale = 1.0;       // of the residuals against what the fit assumed
    bool given = false;       // the fit's density is that of a sample without colour and outliers
    // A magnetometer that rounds: what the model predicts of each sample of each row's node, uT;
    // step, and noise before it; and the standard deviation of a sample in the fit.
    std::vector<std::vector<Vector3>> predicted = {};
    double step = 0.0, before = 0.0, sigma = 1.0;
  };
  // residual: of the fitted model. Rows that are no sensor's keep it: a simulation moves as the
  // recording did, and how far its hand is from the middle, and its parameters from their priors,
  // is no noise.
  SimulatedNoise(VectorXd residual, std::vector<OfSensor> sensors);

  // One standard deviation each, whatever its colour (but where a density was given), times the
  // scale.
  VectorXd draw(std::mt19937_64& random) const;

 private:
  VectorXd residual_;
  std::vector<OfSensor> sensors_;
};

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// The fit of one model at one density of nodes: built, optimized, built again where the variables
// have moved away from where samples were integrated, with the noise re-estimated on request.
// Calibration goes through several: coarse ones to find the noise and to choose between models, and
// a fine one at the end.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "calibration/fit/noise_estimation.h"
#include "calibration/model/model.h"
#include "solvers/levenberg_marquardt.h"

namespace magimu {

class GatheredSamples;

// What is known of the noise before a fit re-estimates it.
struct NoiseKnowledge {
  bool gyr_known = false, acc_known = false,
       mag_known = false;  // leave these densities as they are
  // Densities at the least and at the most, rad/s, uT.
  double min_gyr = 0.0, max_gyr = 1e30, max_mag = 1e30;
  std::vector<double> max_each_mag{};  // of each magnetometer of an array; empty: max_mag
  NoiseDensities least{};  // of accelerometer and gyroscope, from samples in motion (rests.h)
};

// Its fits throw NumericalError where numbers are not finite: there is nothing to go on with. A fit
// that ends elsewhere than in an optimum says so in result().
class Stage {
 public:
  // recordings must outlive the stage. every: magnetometer samples a node.
  Stage(const std::vector<const Recording*>& recordings, const ModelSpec& spec, int every,
        const OptimizerOptions& optimizer);
  // With these nodes.
  Stage(const std::vector<const Recording*>& recordings, const ModelSpec& spec,
        std::vector<NodePlan> plans, const OptimizerOptions& optimizer);
  // Another model of the same recordings and nodes: what it takes from the samples alike is not
  // gathered again.
  Stage(const Stage& like, const ModelSpec& spec);
  Stage(const Stage& like, const ModelSpec& spec, const OptimizerOptions& optimizer);

  // Is it a model of these recordings with these nodes?
  bool is_of(const std::vector<const Recording*>& recordings,
             const std::vector<NodePlan>& plans) const;

  const std::vector<NodePlan>& plans() const { return plans_; }
  const ModelSpec& spec() const { return spec_; }
  const FactorGraph& graph() const { return graph_; }
  // What the graph was made from.
  const GatheredSamples& gathered() const { return *gathered_; }
  const Result& result() const { return result_; }  // of the whole fit, all rounds

  // Optimizes from start. warm: start is an optimum of a model much like this one.
  void fit(const Values& start, bool warm);
  // Fits, re-estimates noise densities (and the hand's reach) in turn until they settle.
  void fit_noise(const Values& start, bool warm, const NoiseKnowledge& known);
  // Fits with the magnetometer factors of some nodes left out.
  void fit_without(const Values& start, const std::function<bool(int node)>& leave_out);

  // Residuals by sensor, at the optimum.
  SensorSums sums() const;
  // The share of the gyroscope's rows that the last fit_noise() found the fit to leave free; 0
  // before.
  double gyr_freedom() const { return gyr_freedom_; }
  // Squared magnetometer residuals, whitened, summed at each node, of the full graph here.
  std::vector<double> mag_squares() const;
  // The same, each times the square of its magnetometer's density: uT^2 per Hz.
  std::vector<double> mag_squares_uT() const;
  // The same of residuals that are known.
  std::vector<double> mag_squares(const SensorRows& rows, const VectorXd& residual) const;

 private:
  void fit(const Values& start, bool warm, double step_tolerance);
  std::vector<double> mag_squares(const SensorRows& rows, const VectorXd& residual,
                                  const std::vector<double>& weight) const;
  void build();
  [[noreturn]] void refuse(const Result& result) const;

  std::vector<const Recording*> recordings_;
  ModelSpec spec_;
  std::vector<NodePlan> plans_;
  OptimizerOptions optimizer_;
  std::shared_ptr<const GatheredSamples> gathered_;
  FactorGraph graph_;
  Result result_;
  double gyr_freedom_ = 0.0;
};

// A stage's optimum carried to another stage's nodes and variables: parameters as they are, each
// node from the nearest one by the gyroscope. of: which recording of `from` each of these is a part
// of; empty: they are the same.
Values carry_over(const std::vector<const Recording*>& recordings, const Stage& from,
                  const Stage& to, const std::vector<std::size_t>& of = {});

}  // namespace magimu

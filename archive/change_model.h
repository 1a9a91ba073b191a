// SPDX-License-Identifier: BSD-3-Clause
// How probable a device's recordings are under a model of how its parameters change from one
// recording to the next: the parameters are a state, each recording measures it,
//
//   x_k = x_(k-1) + w_k,   w_k ~ N(0, Q_k),      recording k: exp(-1/2 x' I_k x + h_k' x)
//
// and the logarithm of the recordings' density comes from a filter in information form, which
// needs nothing but the recordings' summaries. A change point is a transition with a large Q of a
// few parameters at one place; a drift is a small Q everywhere. So both are compared as they are,
// by their likelihoods, with priors on their sizes integrated out.
#pragma once

#include <string>
#include <vector>

#include "graph/scalar.h"

namespace magimu {

// exp(-1/2 x' information x + vector' x + log_factor) as a function of the parameters.
struct Gaussian {
  MatrixXd information;
  VectorXd vector;
  double log_factor = 0.0;

  // The product of two.
  Gaussian& operator*=(const Gaussian& other);
  // Convolved with N(0, G W G'): the parameters' combinations G are uncertain by W on top.
  void blur(const MatrixXd& G, const MatrixXd& W);
  // log of the integral over all x, without the factor (2 pi)^(n/2); -infinity where it diverges.
  double log_integral() const;
  VectorXd mean() const;
  MatrixXd covariance() const;
};

// Parameters, or combinations of them, that change together.
struct ParameterGroup {
  std::string name;   // "hard_iron", "scale", "accelerometer_bias", ...
  std::string words;  // "the hard iron"
  MatrixXd G;         // parameters x combinations
  MatrixXd W;         // covariance of G's combinations as one ordinary recording tells them
};

enum class ChangeKind { kStep, kWalk, kTrend, kScatter };
std::string to_string(ChangeKind kind);

// One way in which one group changes.
struct DeviceChange {
  ChangeKind kind = ChangeKind::kStep;
  std::size_t group = 0;
  std::size_t at = 0;  // kStep: the first recording after it
  double size = 1.0;  // of the change's prior, in standard deviations of one recording; kWalk: from
                      // one recording to the next, on average; kTrend: from first to last
};

// Recordings of one device in the order of time.
struct ChangeProblem {
  std::vector<Gaussian> recordings;
  std::vector<double> time;  // increasing; only differences count
  std::vector<ParameterGroup> groups;
  Gaussian prior;  // of the parameters, proper
};

class ChangeModel {
 public:
  ChangeModel(const ChangeProblem& problem, std::vector<DeviceChange> changes);

  // Of all recordings.
  double log_evidence() const;
  // The same with a step more, before each recording 1, 2, ..., n - 1.
  std::vector<double> log_evidence_with_step(std::size_t group, double size) const;
  // The parameters at each recording, given all of them.
  std::vector<Gaussian> smoothed() const;

 private:
  // The parameters at recording k as a function of those at the start and of the trends' slopes.
  MatrixXd parameters_at(std::size_t k) const;
  Gaussian measurement(std::size_t k) const;
  void transit(Gaussian& state, std::size_t into) const;

  const ChangeProblem& problem_;
  std::vector<DeviceChange> changes_;
  Eigen::Index n_ = 0, extra_ = 0;            // parameters; those of trends
  std::vector<Gaussian> forward_, backward_;  // with recordings 0..k; with k..n-1
};

}  // namespace magimu

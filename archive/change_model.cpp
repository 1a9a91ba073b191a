// SPDX-License-Identifier: BSD-3-Clause
#include "archive/change_model.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

namespace magimu {
namespace {

double log_determinant(const Eigen::LLT<MatrixXd>& llt) {
  return 2.0 * llt.matrixLLT().diagonal().array().log().sum();
}

// Time of recording k as a share of the whole, -1/2 to 1/2.
double share_of_time(const std::vector<double>& time, std::size_t k) {
  const double length = time.back() - time.front();
  return length > 0.0 ? (time[k] - time.front()) / length - 0.5 : 0.0;
}

}  // namespace

std::string to_string(ChangeKind kind) {
  switch (kind) {
    case ChangeKind::kStep:
      return "step";
    case ChangeKind::kWalk:
      return "walk";
    case ChangeKind::kTrend:
      return "trend";
    case ChangeKind::kScatter:
      return "scatter";
  }
  return "";
}

Gaussian& Gaussian::operator*=(const Gaussian& other) {
  information += other.information;
  vector += other.vector;
  log_factor += other.log_factor;
  return *this;
}

// With b = G' (information x - vector) and M = W^-1 + G' information G, the integral over the
// blurring w of N(w; 0, W) adds 1/2 b' M^-1 b - 1/2 log det(W M) to the exponent.
void Gaussian::blur(const MatrixXd& G, const MatrixXd& W) {
  const MatrixXd AG = information * G;
  const Eigen::LLT<MatrixXd> w(W);
  const MatrixXd M = w.solve(MatrixXd::Identity(W.rows(), W.cols())) + MatrixXd(G.transpose() * AG);
  const Eigen::LLT<MatrixXd> m(M);
  const VectorXd Gv = G.transpose() * vector;
  const VectorXd y = m.solve(Gv);
  log_factor += 0.5 * Gv.dot(y) - 0.5 * (log_determinant(w) + log_determinant(m));
  vector -= AG * y;
  information -= AG * m.solve(AG.transpose());
  information = 0.5 * (information + information.transpose()).eval();
}

double Gaussian::log_integral() const {
  const Eigen::LLT<MatrixXd> llt(information);
  if (llt.info() != Eigen::Success) return -std::numeric_limits<double>::infinity();
  return log_factor + 0.5 * vector.dot(llt.solve(vector)) - 0.5 * log_determinant(llt);
}

VectorXd Gaussian::mean() const { return information.llt().solve(vector); }

MatrixXd Gaussian::covariance() const {
  return information.llt().solve(MatrixXd::Identity(information.rows(), information.cols()));
}

ChangeModel::ChangeModel(const ChangeProblem& problem, std::vector<DeviceChange> changes)
    : problem_(problem), changes_(std::move(changes)), n_(problem.prior.vector.size()) {
  for (const DeviceChange& c : changes_) {
    if (c.kind == ChangeKind::kTrend) extra_ += problem_.groups[c.group].G.cols();
  }
  Gaussian begin{MatrixXd::Zero(n_ + extra_, n_ + extra_), VectorXd::Zero(n_ + extra_),
                 problem_.prior.log_factor};
  begin.information.topLeftCorner(n_, n_) = problem_.prior.information;
  begin.vector.head(n_) = problem_.prior.vector;
  Eigen::Index at = n_;
  for (const DeviceChange& c : changes_) {
    if (c.kind != ChangeKind::kTrend) continue;
    const MatrixXd W = c.size * c.size * problem_.groups[c.group].W;
    const Eigen::LLT<MatrixXd> llt(W);
    begin.information.block(at, at, W.rows(), W.rows()) =
        llt.solve(MatrixXd::Identity(W.rows(), W.rows()));
    begin.log_factor -= 0.5 * log_determinant(llt);
    at += W.rows();
  }
  const std::size_t count = problem_.recordings.size();
  Gaussian state = begin;
  for (std::size_t k = 0; k < count; ++k) {
    if (k > 0) transit(state, k);
    forward_.push_back(state *= measurement(k));
  }
  backward_.resize(count);
  for (std::size_t k = count; k-- > 0;) {
    Gaussian own = measurement(k);
    if (k + 1 < count) {
      Gaussian later = backward_[k + 1];
      transit(later, k + 1);
      own *= later;
    }
    backward_[k] = std::move(own);
  }
}

// A trend's share of the time is part of them.
MatrixXd ChangeModel::parameters_at(std::size_t k) const {
  MatrixXd H(n_, n_ + extra_);
  H.leftCols(n_).setIdentity();
  Eigen::Index at = n_;
  for (const DeviceChange& c : changes_) {
    if (c.kind != ChangeKind::kTrend) continue;
    const MatrixXd& G = problem_.groups[c.group].G;
    H.middleCols(at, G.cols()) = share_of_time(problem_.time, k) * G;
    at += G.cols();
  }
  return H;
}

// Recording k as a function of the parameters and of the trends' slopes.
Gaussian ChangeModel::measurement(std::size_t k) const {
  Gaussian own = problem_.recordings[k];
  for (const DeviceChange& c : changes_) {
    if (c.kind != ChangeKind::kScatter) continue;
    const ParameterGroup& group = problem_.groups[c.group];
    own.blur(group.G, c.size * c.size * group.W);
  }
  if (extra_ == 0) return own;
  const MatrixXd H = parameters_at(k);
  return {H.transpose() * own.information * H, H.transpose() * own.vector, own.log_factor};
}

// From recording into - 1 to this one, or back: the same blur.
void ChangeModel::transit(Gaussian& state, std::size_t into) const {
  const std::vector<double>& t = problem_.time;
  const double mean_step = (t.back() - t.front()) / double(t.size() - 1);
  const double steps = mean_step > 0.0 ? (t[into] - t[into - 1]) / mean_step : 1.0;
  for (const DeviceChange& c : changes_) {
    const bool walk = c.kind == ChangeKind::kWalk && steps > 0.0;
    if (!walk && !(c.kind == ChangeKind::kStep && c.at == into)) continue;
    const ParameterGroup& group = problem_.groups[c.group];
    MatrixXd G = MatrixXd::Zero(n_ + extra_, group.G.cols());
    G.topRows(n_) = group.G;
    state.blur(G, c.size * c.size * (walk ? steps : 1.0) * group.W);
  }
}

double ChangeModel::log_evidence() const { return forward_.back().log_integral(); }

std::vector<double> ChangeModel::log_evidence_with_step(std::size_t g, double size) const {
  const ParameterGroup& group = problem_.groups[g];
  MatrixXd G = MatrixXd::Zero(n_ + extra_, group.G.cols());
  G.topRows(n_) = group.G;
  std::vector<double> out;
  for (std::size_t k = 1; k < forward_.size(); ++k) {
    Gaussian state = forward_[k - 1];
    transit(state, k);
    state.blur(G, size * size * group.W);
    out.push_back((state *= backward_[k]).log_integral());
  }
  return out;
}

std::vector<Gaussian> ChangeModel::smoothed() const {
  std::vector<Gaussian> out;
  for (std::size_t k = 0; k < forward_.size(); ++k) {
    Gaussian state = forward_[k];
    if (k + 1 < forward_.size()) {
      Gaussian later = backward_[k + 1];
      transit(later, k + 1);
      state *= later;
    }
    const MatrixXd H = parameters_at(k);
    const VectorXd mean = H * state.mean();
    const MatrixXd S = H * state.covariance() * H.transpose();
    const MatrixXd I = S.llt().solve(MatrixXd::Identity(n_, n_));
    out.push_back({I, I * mean, 0.0});
  }
  return out;
}

}  // namespace magimu

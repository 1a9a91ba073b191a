// SPDX-License-Identifier: BSD-3-Clause
// Factors of one type whose residuals have a linear part in further variables, as many as run time
// asks for:
//
//   r = factor's residual - G (theta - theta_0)
//
// with theta scalars that all factors of the batch share and G a matrix of each factor's own. A
// model is extended so without a factor type for every combination of extensions.
#pragma once

#include <functional>

#include "graph/factor_graph.h"

namespace magimu {

template <class F>
class ExtendedBatch final : public FactorBatch {
 public:
  using Gain = Eigen::Matrix<double, F::kDim, Eigen::Dynamic>;

  // extra: the keys of theta; at: theta_0, one number a key.
  ExtendedBatch(std::vector<Key> extra, VectorXd at)
      : extra_(std::move(extra)), at_(std::move(at)) {
    types_.assign(kTypes.begin(), kTypes.end());
    types_.resize(kTypes.size() + extra_.size(), VariableTraits<double>::type());
  }

  // gain_of: a function for each factor, in their order, that returns its G. G is then computed
  // whenever it is needed and not kept, for a long recording whose G do not fit into memory. The
  // functions are called by several threads. The batch has no SIMD lanes then, and no gain().
  void find_gains_with(std::vector<std::function<Gain()>> gain_of) {
    gain_of_ = std::move(gain_of);
    gains_ = {};
  }

  // Reserves memory for so many factors, and for their G if with_gains.
  void reserve(int factors, bool with_gains = true) {
    const auto n = std::size_t(factors);
    factors_.reserve(n);
    keys_.reserve(n * stride());
    if (with_gains) gains_.reserve(n * std::size_t(F::kDim) * extra_.size());
  }
  void add(const F& factor, const Eigen::Ref<const Gain>& G) {
    add(factor);
    gain(size() - 1) = G;
  }
  // G = 0 until it is written to gain().
  void add(const F& factor) {
    add_without_gain(factor);
    gains_.resize(gains_.size() + std::size_t(F::kDim) * extra_.size(), 0.0);
  }
  // Call find_gains_with() after the last of these.
  void add_without_gain(const F& factor) {
    factors_.push_back(factor);
    keys_.insert(keys_.end(), factor.keys().begin(), factor.keys().end());
    keys_.insert(keys_.end(), extra_.begin(), extra_.end());
  }
  Eigen::Map<Gain> gain(int i) {
    const auto n = Eigen::Index(extra_.size());
    return {gains_.data() + std::ptrdiff_t(i) * F::kDim * n, F::kDim, n};
  }

  int size() const override { return int(factors_.size()); }
  int rows() const override { return F::kDim; }
  int columns() const override { return F::kColumns + int(extra_.size()); }
  std::span<const Key> keys(int i) const override {
    return {keys_.data() + std::size_t(i) * stride(), stride()};
  }
  std::span<const VariableType> types() const override { return types_; }
  std::unique_ptr<FactorBatch> clone() const override {
    return std::make_unique<ExtendedBatch>(*this);
  }

  double cost(std::span<const double> data, const ResolvedKeys& keys, int begin, int end,
              double* residuals) const override {
    const VectorXd moved = begin < end ? moved_by(data, keys) : VectorXd();
    double sum = 0.0;
    for (int i = begin; i < end; ++i) {
      const F& f = factors_[std::size_t(i)];
      ResidualOf<F> r = evaluate(f, stored(data, keys, i));
      if (gain_of_.empty()) {
        r -= gain(i) * moved;
      } else {
        r -= gain_of_[std::size_t(i)]() * moved;
      }
      f.noise().whiten(r);
      sum += f.noise().loss().rho(r.squaredNorm());
      if (residuals == nullptr) continue;
      Eigen::Map<ResidualOf<F>> out(residuals + (i - begin) * F::kDim);
      out = r;
    }
    return 0.5 * sum;
  }

  double linearize(std::span<const double> data, const ResolvedKeys& keys, int begin, int end,
                   double* residuals, double* jacobians) const override {
    using RowMajor = Eigen::Matrix<double, F::kDim, Eigen::Dynamic, Eigen::RowMajor>;
    const VectorXd moved = begin < end ? moved_by(data, keys) : VectorXd();
    double sum = 0.0;
    JacobianOf<F> J;
    Gain G;
    for (int i = begin; i < end; ++i) {
      const F& f = factors_[std::size_t(i)];
      ResidualOf<F> r = magimu::linearize(f, stored(data, keys, i), J);
      if (gain_of_.empty()) {
        G = gain(i);
      } else {
        G = gain_of_[std::size_t(i)]();
      }
      r -= G * moved;
      f.noise().whiten(r);
      f.noise().whiten(J);
      f.noise().whiten(G);
      const double s = r.squaredNorm();
      sum += f.noise().loss().rho(s);
      const double scale = std::sqrt(f.noise().loss().weight(s));
      Eigen::Map<ResidualOf<F>> r_out(residuals + (i - begin) * F::kDim);
      r_out = scale * r;
      Eigen::Map<RowMajor> J_out(jacobians + std::ptrdiff_t(i - begin) * F::kDim * columns(),
                                 F::kDim, columns());
      J_out.leftCols(F::kColumns) = scale * J;
      J_out.rightCols(Eigen::Index(extra_.size())) = -scale * G;
    }
    return 0.5 * sum;
  }

  LaneText lane_text(Isa isa) const override {
    return gain_of_.empty() ? detail::lane_text_of(factors_, isa) : LaneText{};
  }
  void copy_texts(std::span<const int> chosen, double* text) const override {
    detail::copy_texts(factors_, chosen, text);
  }
  const double* whitening(int i) const override {
    return factors_[std::size_t(i)].noise().whitening().data();
  }
  NoiseKinds noise_kinds(int begin, int end) const override {
    return detail::noise_kinds(factors_, begin, end);
  }
  std::span<const double> linear_at() const override {
    return {at_.data(), std::size_t(at_.size())};
  }
  const double* linear_gain(int i) const override { return gain(i).data(); }

 private:
  static constexpr auto kTypes = []<std::size_t... I>(std::index_sequence<I...>) {
    return std::array<VariableType, sizeof...(I)>{
        VariableTraits<detail::VariableOf<F, I>>::type()...};
  }
  (detail::kIndices<F>);

  std::size_t stride() const { return kTypes.size() + extra_.size(); }
  Eigen::Map<const Gain> gain(int i) const {
    const auto n = Eigen::Index(extra_.size());
    return {gains_.data() + std::ptrdiff_t(i) * F::kDim * n, F::kDim, n};
  }
  // theta - theta_0; the same for all factors.
  VectorXd moved_by(std::span<const double> data, const ResolvedKeys& keys) const {
    VectorXd theta(at_.size());
    for (std::size_t j = 0; j < extra_.size(); ++j) {
      theta[Eigen::Index(j)] = data[std::size_t(keys.stored[kTypes.size() + j])];
    }
    return theta - at_;
  }
  Stored<F> stored(std::span<const double> data, const ResolvedKeys& keys, int i) const {
    Stored<F> x;
    for (std::size_t j = 0; j < kTypes.size(); ++j) {
      x[j] = data.data() + keys.stored[std::size_t(i) * stride() + j];
    }
    return x;
  }

  std::vector<Key> extra_;
  VectorXd at_;
  std::vector<VariableType> types_;
  std::vector<F> factors_;
  std::vector<Key> keys_;
  std::vector<double> gains_;
  std::vector<std::function<Gain()>> gain_of_;
};

}  // namespace magimu

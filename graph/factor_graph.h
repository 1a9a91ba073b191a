// SPDX-License-Identifier: BSD-3-Clause
// A sum of factors. Factors of one type lie side by side in a batch, so that evaluating or
// linearizing the graph is one virtual call a batch and none a factor.
#pragma once

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <stdexcept>
#include <typeindex>
#include <vector>

#include "graph/factor.h"
#include "graph/values.h"

namespace magimu {

// Where the factors of a batch find their variables: for factor i and its key j, entry i * kKeys +
// j.
struct ResolvedKeys {
  std::vector<int> stored;   // offset in Values::data()
  std::vector<int> tangent;  // first column
};

// Of some of a batch's factors: are their whitening matrices diagonal, are they all that of the
// batch's first factor, has any a robust loss?
struct NoiseKinds {
  bool diagonal = true, same = true, robust = false;
};

// Factors of one type, seen from the solvers' side.
class FactorBatch {
 public:
  virtual ~FactorBatch() = default;

  virtual int size() const = 0;
  virtual int rows() const = 0;     // of one factor's residual
  virtual int columns() const = 0;  // of one factor's Jacobian
  virtual std::span<const Key> keys(int factor) const = 0;
  virtual std::span<const VariableType> types() const = 0;
  virtual std::unique_ptr<FactorBatch> clone() const = 0;

  // Sum of rho / 2 over the factors begin <= i < end; where residuals is not null, the whitened
  // residuals (before the robust weight) go there, factor by factor.
  virtual double cost(std::span<const double> data, const ResolvedKeys& keys, int begin, int end,
                      double* residuals) const = 0;
  // The same cost; residuals and Jacobians whitened and scaled by sqrt(rho'), so that the gradient
  // of the cost is J'r. Row i of a Jacobian holds columns() numbers, variable by variable.
  virtual double linearize(std::span<const double> data, const ResolvedKeys& keys, int begin,
                           int end, double* residuals, double* jacobians) const = 0;

  // Code that works on several of these factors at once (lanes.h), robust losses aside; none by
  // default.
  virtual LaneText lane_text(Isa) const { return {}; }
  // What that code reads of these factors, one in each lane; text: lane_text().doubles numbers of
  // each, interleaved.
  virtual void copy_texts(std::span<const int> /*factors*/, double* /*text*/) const {}
  // The factor's whitening matrix, rows() squared.
  virtual const double* whitening(int /*factor*/) const { return nullptr; }
  // Of the factors begin <= i < end.
  virtual NoiseKinds noise_kinds(int /*begin*/, int /*end*/) const { return {false, false, false}; }
  // The last columns may be linear (extended_batch.h): residual - gain (x - at), column by column.
  virtual std::span<const double> linear_at() const { return {}; }
  virtual const double* linear_gain(int /*factor*/) const { return nullptr; }
};

namespace detail {

template <class F>
LaneText lane_text_of(const std::vector<F>& factors, Isa isa) {
  if constexpr (kHasLanes<F>) {
    if (!factors.empty()) return lane_text<F>(isa);
  }
  return {};
}
template <class F>
NoiseKinds noise_kinds(const std::vector<F>& factors, int begin, int end) {
  NoiseKinds out;
  for (int i = begin; i < end; ++i) {
    const F& f = factors[std::size_t(i)];
    out.diagonal &= f.noise().is_diagonal();
    out.same &= f.noise().whitening() == factors.front().noise().whitening();
    out.robust |= f.noise().loss().kind != Loss::Kind::kNone;
  }
  return out;
}
template <class F>
void copy_texts(const std::vector<F>& all, std::span<const int> factors, double* text) {
  if constexpr (kHasLanes<F>) {
    using Text = typename F::template Text<double>;
    std::array<double, sizeof(Text) / sizeof(double)> numbers;
    for (std::size_t lane = 0; lane < factors.size(); ++lane) {
      const Text& single = all[std::size_t(factors[lane])];
      std::memcpy(numbers.data(), static_cast<const void*>(&single), sizeof single);
      for (std::size_t k = 0; k < numbers.size(); ++k) {
        text[k * factors.size() + lane] = numbers[k];
      }
    }
  }
}

}  // namespace detail

template <class F>
class FactorBatchOf final : public FactorBatch {
 public:
  std::vector<F> factors;

  int size() const override { return int(factors.size()); }
  int rows() const override { return F::kDim; }
  int columns() const override { return F::kColumns; }
  std::span<const Key> keys(int i) const override { return factors[std::size_t(i)].keys(); }
  std::span<const VariableType> types() const override { return kTypes; }
  std::unique_ptr<FactorBatch> clone() const override {
    return std::make_unique<FactorBatchOf>(*this);
  }

  double cost(std::span<const double> data, const ResolvedKeys& keys, int begin, int end,
              double* residuals) const override {
    double sum = 0.0;
    for (int i = begin; i < end; ++i) {
      const F& f = factors[std::size_t(i)];
      ResidualOf<F> r = evaluate(f, stored(data, keys, i));
      f.noise().whiten(r);
      sum += f.noise().loss().rho(r.squaredNorm());
      if (residuals != nullptr) {
        Eigen::Map<ResidualOf<F>> out(residuals + (i - begin) * F::kDim);
        out = r;
      }
    }
    return 0.5 * sum;
  }

  double linearize(std::span<const double> data, const ResolvedKeys& keys, int begin, int end,
                   double* residuals, double* jacobians) const override {
    using RowMajor = Eigen::Matrix<double, F::kDim, F::kColumns,
                                   F::kColumns == 1 ? Eigen::ColMajor : Eigen::RowMajor>;
    double sum = 0.0;
    JacobianOf<F> J;
    for (int i = begin; i < end; ++i) {
      const F& f = factors[std::size_t(i)];
      ResidualOf<F> r = magimu::linearize(f, stored(data, keys, i), J);
      f.noise().whiten(r);
      f.noise().whiten(J);
      const double s = r.squaredNorm();
      sum += f.noise().loss().rho(s);
      if (f.noise().loss().kind != Loss::Kind::kNone) {
        const double scale = std::sqrt(f.noise().loss().weight(s));
        r *= scale;
        J *= scale;
      }
      Eigen::Map<ResidualOf<F>> r_out(residuals + (i - begin) * F::kDim);
      r_out = r;
      Eigen::Map<RowMajor> J_out(jacobians + (i - begin) * F::kDim * F::kColumns);
      J_out = J;
    }
    return 0.5 * sum;
  }

  LaneText lane_text(Isa isa) const override { return detail::lane_text_of(factors, isa); }
  void copy_texts(std::span<const int> chosen, double* text) const override {
    detail::copy_texts(factors, chosen, text);
  }
  const double* whitening(int i) const override {
    return factors[std::size_t(i)].noise().whitening().data();
  }
  NoiseKinds noise_kinds(int begin, int end) const override {
    return detail::noise_kinds(factors, begin, end);
  }

 private:
  static constexpr auto kTypes = []<std::size_t... I>(std::index_sequence<I...>) {
    return std::array<VariableType, sizeof...(I)>{
        VariableTraits<detail::VariableOf<F, I>>::type()...};
  }
  (detail::kIndices<F>);

  static Stored<F> stored(std::span<const double> data, const ResolvedKeys& keys, int i) {
    Stored<F> x;
    for (int j = 0; j < F::kKeys; ++j) {
      x[std::size_t(j)] = data.data() + keys.stored[std::size_t(i) * F::kKeys + std::size_t(j)];
    }
    return x;
  }
};

class FactorGraph {
 public:
  FactorGraph() = default;
  FactorGraph(const FactorGraph& other);
  FactorGraph& operator=(const FactorGraph& other);
  FactorGraph(FactorGraph&&) = default;
  FactorGraph& operator=(FactorGraph&&) = default;

  // Copies the factor in. Throws std::invalid_argument if it names one variable twice.
  template <class F>
  void add(const F& factor) {
    if constexpr (check_factor<F>()) {
      check_keys(factor.keys());
      mutable_batch<F>().factors.push_back(factor);
    }
  }

  // A batch made elsewhere (extended_batch.h); factors<F>() does not see it.
  void add_batch(std::unique_ptr<FactorBatch> batch);

  // The factors of one type, in the order in which they were added.
  template <class F>
  const std::vector<F>& factors() const {
    static const std::vector<F> none;
    const auto it = index_.find(typeid(F));
    return it == index_.end() ? none
                              : static_cast<const FactorBatchOf<F>&>(*batches_[it->second]).factors;
  }
  // The same, to change measurements between two optimizations (re-integration, for example).
  template <class F>
  std::vector<F>& mutable_factors() {
    return mutable_batch<F>().factors;
  }

  int size() const;  // number of factors
  std::span<const std::unique_ptr<FactorBatch>> batches() const { return batches_; }

  // Half the sum of the squared whitened residuals (of rho, where a factor has a loss).
  double cost(const Values& values) const;

 private:
  template <class F>
  FactorBatchOf<F>& mutable_batch() {
    const auto [it, added] = index_.try_emplace(typeid(F), batches_.size());
    if (added) batches_.push_back(std::make_unique<FactorBatchOf<F>>());
    return static_cast<FactorBatchOf<F>&>(*batches_[it->second]);
  }
  static void check_keys(std::span<const Key> keys);

  std::vector<std::unique_ptr<FactorBatch>> batches_;
  std::map<std::type_index, std::size_t> index_;
};

}  // namespace magimu

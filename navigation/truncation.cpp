// SPDX-License-Identifier: BSD-3-Clause
#include "navigation/truncation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "recording/error.h"

namespace magimu {

FieldProcess truncation_process(const ArraySamples& samples, int order) {
  ArrayFilterOptions options;
  options.order = order;
  options.field = ArrayFilterOptions::published_process(order);
  const ArrayFilter filter(options, samples.positions);
  const int lower = FieldBasis::size_of(order), from = FieldBasis::size_of(order - 1);

  double squares = 0.0;
  std::size_t count = 0;
  for (std::size_t k = 0; k < samples.t.size(); ++k) {
    if (!samples.measured[k]) continue;
    const VectorXd theta = filter.fit_field(samples.mag.col(static_cast<Eigen::Index>(k)));
    squares += theta.tail(lower - from).squaredNorm() / (lower - from);
    ++count;
  }
  Vector3 centre = Vector3::Zero();
  for (const Vector3& r : samples.positions) {
    centre += r / static_cast<double>(samples.positions.size());
  }
  double radius = 0.0;
  for (const Vector3& r : samples.positions) radius = std::max(radius, (r - centre).norm());

  const int kappa = FieldBasis::size_of(order + 1);
  FieldProcess process{VectorXd::Zero(kappa), VectorXd::Zero(kappa), 2.0 * radius};
  const double size = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, count)));
  process.spread.tail(kappa - lower).setConstant(size / radius);
  return process;
}

ArrayFilterOptions with_truncation(const ArrayFilterOptions& options, const ArraySamples& samples) {
  if (options.order >= FieldBasis::kHighestOrder) {
    throw InputError(samples.name, 0, 0,
                     fmt::format("order {} leaves no degree for the truncation", options.order),
                     "lower the order");
  }
  ArrayFilterOptions out = options;
  out.order = options.order + 1;
  out.field = truncation_process(samples, options.order);
  return out;
}

}  // namespace magimu

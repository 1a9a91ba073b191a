// SPDX-License-Identifier: BSD-3-Clause
#include "navigation/truncation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "recording/data/error.h"

namespace magimu {

FieldProcess truncation_process(const ArraySamples& samples, int order) {
  ArrayFilterOptions options;
  options.order = order + 1;
  options.field = ArrayFilterOptions::published_process(order + 1);
  const ArrayFilter filter(options, samples.positions);
  const int kappa = FieldBasis::size_of(order + 1), lower = FieldBasis::size_of(order);
  const int count = kappa - lower;  // of the truncated degree

  // Of one sample's fit, E |theta|^2 = |truth|^2 + s^2 tr(Phi' Phi)^-1, s^2 from the same fit.
  const double unit_noise = filter.fit_variance().tail(count).sum();
  double squares = 0.0, noise = 0.0;
  std::size_t fits = 0;
  for (std::size_t k = 0; k < samples.t.size(); ++k) {
    if (!samples.measured[k]) continue;
    const ArrayFilter::Fit fit = filter.fit(samples.mag.col(static_cast<Eigen::Index>(k)));
    squares += fit.theta.tail(count).squaredNorm();
    noise += fit.variance * unit_noise;
    ++fits;
  }
  const auto n = static_cast<double>(std::max<std::size_t>(1, fits));
  // A spread below its own standard error cannot be distinguished from noise. (2 / (fits * count)
  // is the relative variance of a mean of squares.)
  const double least = noise * std::sqrt(2.0 / (n * count));
  const double size = std::sqrt(std::max(squares - noise, least) / (n * count));

  Vector3 centre = Vector3::Zero();
  for (const Vector3& r : samples.positions) {
    centre += r / static_cast<double>(samples.positions.size());
  }
  double radius = 0.0;
  for (const Vector3& r : samples.positions) radius = std::max(radius, (r - centre).norm());
  FieldProcess process{VectorXd::Zero(kappa), VectorXd::Zero(kappa), 2.0 * radius};
  process.spread.tail(count).setConstant(size);
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
  if (const int most = highest_order(samples.positions); out.order > most) {
    const std::string white = fmt::format("`--order {} --truncation white`", most);
    throw InputError(
        samples.name, 0, 0,
        fmt::format("the magnetometers at these places ({}) tell fields up to order {} apart, and "
                    "a field of order {} with its truncation coloured takes order {}",
                    samples.positions.size(), most, options.order, out.order),
        most > 1   ? fmt::format("give `--order {}`, or {}", most - 1, white)
        : most > 0 ? "give " + white
                   : "look at the layout, or navigate without them: `--method ins`");
  }
  out.field = truncation_process(samples, options.order);
  out.shrink_gradients = true;
  return out;
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
#include "archive/recording_summary.h"

#include <Eigen/QR>
#include <algorithm>

#include "graph/json_numbers.h"
#include "recording/data/error.h"
#include "solvers/tree/condensed_triangle.h"

namespace magimu {
namespace {

using SummaryJson = nlohmann::ordered_json;

constexpr double kUndetermined = 1e-9;  // singular values of scaled columns: rounding below

// Row by row from the diagonal on.
SummaryJson upper(const MatrixXd& m) {
  SummaryJson out = SummaryJson::array();
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    for (Eigen::Index j = i; j < m.cols(); ++j) out.push_back(m(i, j));
  }
  return out;
}

VectorXd vector_in(const SummaryJson& json, const char* name, Eigen::Index size) {
  const SummaryJson& list = json.at(name);
  if (!list.is_array() || Eigen::Index(list.size()) != size) throw std::out_of_range(name);
  VectorXd out(size);
  for (Eigen::Index i = 0; i < size; ++i) out[i] = list[std::size_t(i)].get<double>();
  return out;
}

MatrixXd upper_in(const SummaryJson& json, const char* name, Eigen::Index n) {
  const VectorXd packed = vector_in(json, name, n * (n + 1) / 2);
  MatrixXd out = MatrixXd::Zero(n, n);
  Eigen::Index k = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = i; j < n; ++j) out(i, j) = packed[k++];
  }
  return out;
}

SummaryJson columns(const MatrixXd& m) {
  SummaryJson out = SummaryJson::array();
  for (Eigen::Index j = 0; j < m.cols(); ++j) {
    out.push_back(json_numbers<SummaryJson>(VectorXd(m.col(j))));
  }
  return out;
}

MatrixXd columns_in(const SummaryJson& json, const char* name, Eigen::Index rows) {
  const SummaryJson& list = json.at(name);
  MatrixXd out(rows, Eigen::Index(list.size()));
  for (std::size_t j = 0; j < list.size(); ++j) {
    if (Eigen::Index(list[j].size()) != rows) throw std::out_of_range(name);
    for (Eigen::Index i = 0; i < rows; ++i) {
      out(i, Eigen::Index(j)) = list[j][std::size_t(i)].get<double>();
    }
  }
  return out;
}

bool is_dip(const std::string& name) { return name == "field.dip_deg"; }

}  // namespace

SummaryJson to_json(const CondensedRecording& c) {
  SummaryJson out = {{"order", c.order},
                     {"at", json_numbers<SummaryJson>(c.at)},
                     {"triangle", upper(c.R)},
                     {"d", json_numbers<SummaryJson>(c.d)},
                     {"squares", c.squares},
                     {"rows", c.rows},
                     {"covariance", upper(c.covariance)},
                     {"moved", columns(c.moved)},
                     {"beyond_noise", upper(c.beyond_noise)},
                     {"prior_mean", json_numbers<SummaryJson>(c.prior_mean)},
                     {"prior_sigma", json_numbers<SummaryJson>(c.prior_sigma)}};
  if (c.common.size() > 0) {
    out["common"] = upper(c.common);
    if (!c.common_in_triangle) out["common_in_triangle"] = false;
  }
  return out;
}

CondensedRecording condensed_from_json(const SummaryJson& json, const std::string& file) {
  try {
    CondensedRecording out;
    out.order = json.at("order").get<std::vector<std::string>>();
    const auto n = Eigen::Index(out.order.size());
    out.at = vector_in(json, "at", n);
    out.R = upper_in(json, "triangle", n);
    out.d = vector_in(json, "d", n);
    out.squares = json.at("squares").get<double>();
    out.rows = json.at("rows").get<int>();
    const MatrixXd U = upper_in(json, "covariance", n);
    out.covariance = U.selfadjointView<Eigen::Upper>();
    out.moved = columns_in(json, "moved", n);
    out.beyond_noise = upper_in(json, "beyond_noise", n).selfadjointView<Eigen::Upper>();
    if (json.contains("common")) {
      out.common = upper_in(json, "common", n).selfadjointView<Eigen::Upper>();
      out.common_in_triangle = json.value("common_in_triangle", true);
    }
    out.prior_mean = vector_in(json, "prior_mean", n);
    out.prior_sigma = vector_in(json, "prior_sigma", n);
    return out;
  } catch (const std::exception& error) {  // of the JSON library, or of a wrong length
    throw InputError(file, 0, 0, std::string("its summary cannot be used: ") + error.what(),
                     "remove the file and run magimu reprocess again");
  }
}

VectorXd RecordingSummary::own() const {
  CondensedTriangle t;
  t.globals = int(at.size());
  t.R.resize(at.size(), at.size() + 1);
  t.R << R, d;
  return at + solve(t, kUndetermined);
}

RecordingSummary summary_of(const CondensedRecording& c, double widened) {
  const auto n = Eigen::Index(c.order.size());
  std::vector<Eigen::Index> kept;
  Eigen::Index dip = -1;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (is_dip(c.order[std::size_t(i)])) {
      dip = i;
    } else {
      kept.push_back(i);
    }
  }
  const auto m = Eigen::Index(kept.size());
  RecordingSummary out;
  out.at.resize(m);
  out.prior_mean.resize(m);
  out.prior_sigma.resize(m);
  MatrixXd rows(n, n + 1);  // [dip | shared | d]
  if (dip >= 0) rows.col(0) = c.R.col(dip);
  const Eigen::Index first = dip >= 0 ? 1 : 0;
  MatrixXd V(m, m);
  for (Eigen::Index i = 0; i < m; ++i) {
    const Eigen::Index at = kept[std::size_t(i)];
    out.order.push_back(c.order[std::size_t(at)]);
    out.at[i] = c.at[at];
    out.prior_mean[i] = c.prior_mean[at];
    out.prior_sigma[i] = c.prior_sigma[at];
    rows.col(first + i) = c.R.col(at);
    for (Eigen::Index j = 0; j < m; ++j) {
      V(i, j) = widened * widened * c.covariance(at, kept[std::size_t(j)]);
    }
  }
  rows.col(n) = c.d;
  const Eigen::HouseholderQR<MatrixXd> qr(rows.leftCols(n));
  MatrixXd triangle(n, n + 1);
  triangle.leftCols(n) = qr.matrixQR().triangularView<Eigen::Upper>();
  triangle.col(n) = qr.householderQ().transpose() * rows.col(n);
  out.R = triangle.block(first, first, m, m);
  out.d = triangle.col(n).tail(m);
  out.covariance = V;
  if (c.common.size() > 0) out.common = c.common(kept, kept);
  out.common_in_triangle = c.common_in_triangle;
  out.moved = widened * c.moved(kept, Eigen::all);
  out.beyond_noise = widened * widened * c.beyond_noise(kept, kept);
  out.dip_row = VectorXd::Zero(m);
  if (dip >= 0 && std::abs(triangle(0, 0)) > 0.0) {
    out.dip_at = c.at[dip] - triangle(0, n) / triangle(0, 0);
    out.dip_row = triangle.block(0, 1, 1, m).transpose() / triangle(0, 0);
    out.dip_sigma = 1.0 / std::abs(triangle(0, 0));
  }
  return out;
}

}  // namespace magimu

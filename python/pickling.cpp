// SPDX-License-Identifier: BSD-3-Clause
#include "python/pickling.h"

#include <nlohmann/json.hpp>
#include <sstream>

#include "calibration/result/calibration_json.h"
#include "graph/bytes.h"
#include "recording/data/error.h"

namespace magimu::python {
namespace {

template <int N>
void put(ByteWriter& out, const std::vector<Vec<double, N>>& vectors) {
  std::vector<double> numbers;
  numbers.reserve(N * vectors.size());
  for (const auto& v : vectors) numbers.insert(numbers.end(), v.data(), v.data() + N);
  out.put(numbers);
}
template <int N>
void get(ByteReader& in, std::vector<Vec<double, N>>& vectors) {
  const auto numbers = in.get<std::vector<double>>();
  for (std::size_t i = 0; i + N <= numbers.size(); i += N) {
    vectors.push_back(Eigen::Map<const Vec<double, N>>(numbers.data() + i));
  }
}

void put(ByteWriter& out, const std::vector<Rot3>& rotations) {
  std::vector<Vector4> quaternions;
  for (const Rot3& R : rotations) quaternions.push_back(R.quaternion());
  put<4>(out, quaternions);
}
void get(ByteReader& in, std::vector<Rot3>& rotations) {
  std::vector<Vector4> quaternions;
  get<4>(in, quaternions);
  for (const Vector4& q : quaternions) rotations.push_back(Rot3::from_unit_quaternion(q));
}

void put(ByteWriter& out, const std::vector<bool>& flags) {
  out.put(std::vector<char>(flags.begin(), flags.end()));
}
void get(ByteReader& in, std::vector<bool>& flags) {
  const auto chars = in.get<std::vector<char>>();
  flags.assign(chars.begin(), chars.end());
}

void put(ByteWriter& out, const std::vector<std::string>& texts) {
  out.put(std::uint64_t(texts.size()));
  for (const std::string& text : texts) out.put(text);
}
void get(ByteReader& in, std::vector<std::string>& texts) {
  const auto n = in.get<std::uint64_t>();
  for (std::uint64_t i = 0; i < n; ++i) texts.push_back(in.get<std::string>());
}

void put(ByteWriter& out, const VectorSeries& series) {
  out.put(series.t);
  put<3>(out, series.v);
}
void get(ByteReader& in, VectorSeries& series) {
  in.get(series.t);
  get<3>(in, series.v);
}

void put(ByteWriter& out, const MotionTruth& truth) {
  out.put(truth.t);
  put(out, truth.nRb);
  put<3>(out, truth.position);
  put(out, truth.valid);
  put(out, truth.moving);
}
void get(ByteReader& in, MotionTruth& truth) {
  in.get(truth.t);
  get(in, truth.nRb);
  get<3>(in, truth.position);
  get(in, truth.valid);
  get(in, truth.moving);
}

void put(ByteWriter& out, const SetAside& s) {
  put(out, std::vector<std::string>{s.sensor, s.kind, s.example});
  out.put(std::vector<double>{double(s.count), double(s.of), s.begin_s, s.end_s});
}
void get(ByteReader& in, SetAside& s) {
  std::vector<std::string> texts;
  get(in, texts);
  const auto numbers = in.get<std::vector<double>>();
  s = {texts.at(0),
       texts.at(1),
       std::size_t(numbers.at(0)),
       std::size_t(numbers.at(1)),
       numbers.at(2),
       numbers.at(3),
       texts.at(2)};
}

template <class Body>
std::string written(const Body& body) {
  std::ostringstream text;
  ByteWriter out(text);
  body(out);
  out.finish();
  return text.str();
}
template <class Body>
void read_whole(const std::string& bytes, const Body& body) {
  std::istringstream text(bytes);
  if (!is_whole(text)) {
    throw InputError("pickle", 0, 0, "the bytes are damaged", "pickle it again");
  }
  ByteReader in(text);
  body(in);
}

}  // namespace

std::string bytes_of(const Recording& r) {
  return written([&](ByteWriter& out) {
    out.put(r.name);
    put(out, r.acc);
    put(out, r.gyr);
    put(out, r.mag_names);
    for (const VectorSeries& mag : r.mag) put(out, mag);
    out.put(std::uint64_t(r.aux.size()));
    for (const auto& [name, series] : r.aux) {
      out.put(name);
      out.put(series.t);
      out.put(series.v);
    }
    out.put(r.pos.has_value());
    if (r.pos) put(out, *r.pos);
    out.put(r.truth.has_value());
    if (r.truth) put(out, *r.truth);
    put(out, r.notes);
    put(out, r.cautions);
    out.put(std::uint64_t(r.file_units.size()));
    for (const auto& [quantity, unit] : r.file_units) {
      out.put(quantity);
      out.put(unit);
    }
    out.put(std::uint64_t(r.set_aside.size()));
    for (const SetAside& s : r.set_aside) put(out, s);
    out.put(r.continues_previous);
  });
}

Recording recording_from_bytes(const std::string& bytes) {
  Recording r;
  read_whole(bytes, [&](ByteReader& in) {
    in.get(r.name);
    get(in, r.acc);
    get(in, r.gyr);
    get(in, r.mag_names);
    r.mag.resize(r.mag_names.size());
    for (VectorSeries& mag : r.mag) get(in, mag);
    for (auto n = in.get<std::uint64_t>(); n > 0; --n) {
      ScalarSeries& series = r.aux[in.get<std::string>()];
      in.get(series.t);
      in.get(series.v);
    }
    if (in.get<bool>()) get(in, r.pos.emplace());
    if (in.get<bool>()) get(in, r.truth.emplace());
    get(in, r.notes);
    get(in, r.cautions);
    for (auto n = in.get<std::uint64_t>(); n > 0; --n) {
      double& unit = r.file_units[in.get<std::string>()];
      in.get(unit);
    }
    r.set_aside.resize(in.get<std::uint64_t>());
    for (SetAside& s : r.set_aside) get(in, s);
    in.get(r.continues_previous);
  });
  return r;
}

std::string bytes_of(const Fitted& f) {
  return written([&](ByteWriter& out) {
    out.put(json_of(f));
    out.put(file_of(f));
    out.put(std::uint64_t(f.calibration.trajectories.size()));
    for (const TrajectoryEstimate& t : f.calibration.trajectories) {
      out.put(t.recording);
      out.put(t.t);
      put(out, t.nRb);
      put<3>(out, t.v);
      put<3>(out, t.p);
    }
    out.put(std::uint64_t(f.calibration.residual_series.size()));
    for (const ResidualSeries& r : f.calibration.residual_series) {
      out.put(r.sensor);
      out.put(r.t);
      put<3>(out, r.whitened);
    }
  });
}

std::shared_ptr<Fitted> fitted_from_bytes(const std::string& bytes) {
  std::shared_ptr<Fitted> out;
  read_whole(bytes, [&](ByteReader& in) {
    out = fitted_from(in.get<std::string>(), "pickle");
    in.get(out->file);
    Calibration& c = out->calibration;
    c.trajectories.resize(in.get<std::uint64_t>());
    for (TrajectoryEstimate& t : c.trajectories) {
      in.get(t.recording);
      in.get(t.t);
      get(in, t.nRb);
      get<3>(in, t.v);
      get<3>(in, t.p);
    }
    c.residual_series.resize(in.get<std::uint64_t>());
    for (ResidualSeries& r : c.residual_series) {
      in.get(r.sensor);
      in.get(r.t);
      get<3>(in, r.whitened);
    }
  });
  return out;
}

}  // namespace magimu::python

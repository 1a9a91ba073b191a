// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conclude/place.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/model/extension.h"
#include "diagnosis/conclude/missing_state.h"
#include "diagnosis/result/sentence_words.h"
#include "graph/numerical_error.h"
#include "graph/parallel.h"

namespace magimu {
namespace {

constexpr int kRounds = 6;             // linearizations of field and positions, at most
constexpr double kSettled = 0.05;      // of theta, in its prior standard deviations
constexpr double kBlock = 20.0;        // s, left out at the least
constexpr double kLeastReach = 0.01;   // m: positions are not known better than that
constexpr int kMostCoefficients = 63;  // three recordings with the highest order
constexpr std::size_t kPoints = 600;   // of a picture

struct Nodes {
  std::vector<Vector3> position;
  std::vector<int> recording;
  std::vector<double> time;
};
Nodes nodes_of(const Stage& stage) {
  Nodes out;
  for (std::size_t r = 0; r < stage.plans().size(); ++r) {
    const NodePlan& plan = stage.plans()[r];
    for (std::size_t k = 0; k < plan.t.size(); ++k) {
      out.position.push_back(stage.result().values.at<Vector3>(P(plan.first + int(k))));
      out.recording.push_back(int(r));
      out.time.push_back(plan.t[k]);
    }
  }
  return out;
}

struct PlaceFit {
  std::shared_ptr<const FieldOfPlace> field;
  DisturbanceFit process;
};

// Readings depend on the product of field coefficients and positions: linearized about the last
// estimate again and again, until that stays.
void settle(DisturbanceModel& model, FieldOfPlace& field, const DisturbanceFit& process,
            int rounds) {
  for (int round = 0; round < rounds && process.size > 0.0; ++round) {
    PlaceEstimate estimate = model.place(process);
    const double moved = (estimate.theta - field.theta()).cwiseAbs().maxCoeff();
    field.linearize_at(estimate.theta, std::move(estimate.shift));
    model.set_place(std::make_shared<const FieldOfPlace>(field));
    if (moved < kSettled) break;
  }
}

// size_uT: expected of each degree; start: of the process beside it.
PlaceFit fit_place(const Stage& stage, const Nodes& nodes, int order, double size_uT,
                   const DisturbanceFit& start, const DisturbanceOptions& options) {
  DisturbanceModel model(stage, DisturbedPart::kField, options);
  FieldOfPlace field(nodes.position, nodes.recording, order, size_uT);
  model.set_place(std::make_shared<const FieldOfPlace>(field));
  settle(model, field, start, 1);
  const DisturbanceFit process = model.fit_near(start);
  settle(model, field, process, kRounds);
  return {std::make_shared<const FieldOfPlace>(field),
          model.fit_near(process.size > 0.0 ? process : start)};
}

struct Block {
  int recording;
  TimeSpan span;
};
std::vector<Block> blocks_of(const Stage& stage) {
  std::vector<Block> out;
  for (std::size_t r = 0; r < stage.plans().size(); ++r) {
    const double begin = stage.plans()[r].t.front(), end = stage.plans()[r].t.back();
    const int n = int((end - begin) / kBlock);
    for (int i = 0; i < n; ++i) {
      const double h = (end - begin) / n;
      out.push_back({int(r), {begin + i * h, begin + (i + 1) * h}});
    }
  }
  return out;
}

// Negative log density of a block given all else but the guards about it: of two sets of samples,
// each linear about its own estimate. field: of the place; null: none, and the model has none yet.
double nll_of_block(DisturbanceModel& model, const Block& block, double guard_s,
                    const FieldOfPlace* field, const DisturbanceFit& process, int rounds) {
  const double begin = block.span.begin_s, end = block.span.end_s;
  const auto log_density = [&](const std::vector<DisturbanceModel::LeftOut>& left_out) {
    model.leave_out(left_out);
    if (field != nullptr) {
      FieldOfPlace own = *field;
      model.set_place(std::make_shared<const FieldOfPlace>(own));
      settle(model, own, process, rounds);
    }
    return model.log_density(process);
  };
  const double without = log_density({{block.recording, {begin - guard_s, end + guard_s}}});
  // The guards alone, their ends at the block not included.
  constexpr double kApart = 1e-6;
  const double with = log_density({{block.recording, {begin - guard_s, begin - kApart}},
                                   {block.recording, {end + kApart, end + guard_s}}});
  return without - with;
}

void predict_blocks(const Stage& stage, const PlaceFit& with, const DisturbanceFit& alone,
                    const DisturbanceOptions& options, PlaceCheck& check) {
  const std::vector<Block> blocks = blocks_of(stage);
  if (blocks.size() < 2) return;
  check.block_s = blocks.front().span.length_s();
  check.guard_s = std::min(alone.memory_s, check.block_s);
  const int rounds = check.gain_nats > 0.0 ? kRounds : 0;
  struct Nll {
    double alone, with;
  };
  std::vector<Nll> nll(blocks.size());
  parallel::for_each(blocks.size(), [&](std::size_t i) {
    DisturbanceModel model(stage, DisturbedPart::kField, options);
    nll[i].alone = nll_of_block(model, blocks[i], check.guard_s, nullptr, alone, 0);
    nll[i].with =
        nll_of_block(model, blocks[i], check.guard_s, with.field.get(), with.process, rounds);
  });
  check.blocks = int(blocks.size());
  for (const Nll& n : nll) {
    check.nll_place += n.with;
    check.nll_process += n.alone;
    check.blocks_better += n.with < n.alone;
  }
  // Beside a large misfit the model's own approximations gain tens of nats.
  check.comes_back = check.predicts_nats() > std::max(kDecided, kCrumb * alone.gain_nats);
}

void describe_field(const Nodes& nodes, const PlaceFit& fit, PlaceCheck& check) {
  const FieldOfPlace& field = *fit.field;
  double squares = 0.0;
  Vector3 mean = Vector3::Zero();
  const double n = double(nodes.time.size());
  for (std::size_t k = 0; k < nodes.time.size(); ++k) mean += field.field_uT(k) / n;
  double gradient = 0.0;
  for (std::size_t k = 0; k < nodes.time.size(); ++k) {
    squares += (field.field_uT(k) - mean).squaredNorm() / n;
    gradient += field.gradient(k).squaredNorm() / n;
  }
  check.field_uT = std::sqrt(squares);
  check.gradient_uT_m = std::sqrt(gradient);
}

// The departure, and what of it is the field of the place.
void add_points(const Stage& stage, const Nodes& nodes, const PlaceFit& fit,
                const DisturbanceOptions& options, PlaceCheck& check) {
  DisturbanceModel model(stage, DisturbedPart::kField, options);
  model.set_place(fit.field);
  const DisturbanceSeries left = model.smooth(fit.process);
  const std::size_t every = 1 + left.t.size() / kPoints;
  std::size_t k = 0;
  for (std::size_t j = 0; j < left.t.size(); j += every) {
    while (k + 1 < nodes.time.size() &&
           (nodes.recording[k] < left.recording[j] || nodes.time[k] < left.t[j])) {
      ++k;
    }
    const Vector3 b = fit.field->field_uT(k);
    check.points.push_back({left.t[j], fit.field->position(k), b + left.mean[j], b});
  }
}

}  // namespace

void stand_beside(const PlaceRival& rival, double evidence, PlaceCheck& check) {
  const double ahead = evidence - rival.evidence;
  if (ahead >= check.ahead_nats) return;
  check.ahead_nats = ahead;
  check.rival = rival.what;
  check.ahead = ahead >= kDecided;
}

ConfirmedPlace confirm_place(const Stage& stage, const DisturbanceFit& alone,
                             const std::vector<PlaceRival>& rivals,
                             const DisturbanceOptions& options) {
  ConfirmedPlace out;
  PlaceCheck& check = out.check;
  if (stage.spec().motion != MotionModel::kHandHeld || !(alone.size > 0.0)) return out;
  const Nodes nodes = nodes_of(stage);
  check.reach_m = FieldOfPlace(nodes.position, nodes.recording, 1, alone.size).reach_m();
  const int recordings = int(stage.plans().size());
  const auto affordable = [&](int order) {
    return recordings * (FieldBasis::size_of(order) - 3) <= kMostCoefficients;
  };
  if (check.reach_m < kLeastReach || !affordable(1)) return out;
  // Higher orders where a gradient explains anything.
  std::vector<PlaceFit> fits(FieldOfPlace::kHighestOrder);
  fits[0] = fit_place(stage, nodes, 1, alone.size, alone, options);
  const PlaceFit* best = fits.data();
  if (best->process.evidence > alone.evidence) {
    parallel::for_each(fits.size() - 1, [&](std::size_t i) {
      const int order = int(i) + 2;
      if (!affordable(order)) return;
      fits[i + 1] = fit_place(stage, nodes, order, alone.size, fits[0].process, options);
    });
  }
  for (const PlaceFit& fit : fits) {
    if (fit.field && fit.process.evidence > best->process.evidence) best = &fit;
  }
  check.asked = true;
  check.order = best->field->order();
  check.gain_nats = best->process.evidence - alone.evidence;
  check.process_nats = alone.gain_nats;
  check.left_nats = best->process.gain_nats;
  check.ahead_nats = check.gain_nats;
  check.rival = "a process of the field that knows no place";
  check.ahead = check.ahead_nats >= kDecided;
  for (const PlaceRival& rival : rivals) stand_beside(rival, best->process.evidence, check);
  describe_field(nodes, *best, check);
  predict_blocks(stage, *best, alone, options, check);
  add_points(stage, nodes, *best, options, check);
  check.fields = best->field->harmonic_fields();
  out.field = best->field;
  out.beside = best->process;
  return out;
}

std::optional<Stage> model_with_place(const Pipeline& pipeline, const Stage& stage,
                                      const FieldOfPlace& field) {
  for (std::size_t r = 0; r < stage.plans().size(); ++r) {
    if (stage.plans()[r].field != int(r)) return std::nullopt;
  }
  if (stage.spec().mag_offset_s.size() > 1 || stage.spec().mag_time_offset) return std::nullopt;
  ModelSpec spec = stage.spec();
  spec.effects.push_back(make_harmonic_field(field.order(), field.harmonic_fields()));
  spec.extended.clear();
  // Positions as they are beside the field: the fit without it may have let the hand wander off.
  Values start = stage.result().values;
  std::size_t node = 0;
  for (const NodePlan& plan : stage.plans()) {
    for (std::size_t k = 0; k < plan.t.size(); ++k) {
      start.update(P(plan.first + int(k)), field.position(node++));
    }
  }
  const VectorXd c = field.coefficients_uT();
  const std::vector<Key> keys = effect_keys(spec.effects).back();
  for (std::size_t i = 0; i < keys.size(); ++i) start.insert(keys[i], c[Eigen::Index(i)]);
  std::optional<Stage> placed = attempt([&] { return pipeline.refit(spec, start); });
  if (placed && !placed->result().converged()) placed.reset();
  return placed;
}

Finding finding_of_place(const PlaceCheck& p, const DisturbanceFit& beside) {
  Finding f;
  f.effect = "field_departure";
  f.channel = "mag";
  f.sentence = fmt::format(
      "The field differs from place to place: along the sensor's path by {:.2g} uT (root mean "
      "square; {:.2g} uT/m), a function of the place of order {} that takes {:.0f} % of what is "
      "missing in the field. It comes back: {} of {} blocks of {:.0f} s that were left out are "
      "predicted better with it, all together by {}.",
      p.field_uT, p.gradient_uT_m, p.order, 100.0 * p.taken_share(), p.blocks_better, p.blocks,
      p.block_s, nats(p.predicts_nats()));
  f.parameters = {{"field", p.field_uT, 0.0, "uT"},
                  {"gradient", p.gradient_uT_m, 0.0, "uT/m"},
                  {"order", double(p.order), 0.0, "1"},
                  {"size", beside.size, 0.0, "uT"},
                  {"memory", beside.size > 0.0 ? beside.memory_s : 0.0, 0.0, "s"}};
  f.p_value = std::exp(-p.ahead_nats);
  f.probability = 1.0 / (1.0 + f.p_value);
  f.gain = {.heldout_nll_before = p.nll_process,
            .heldout_nll_after = p.nll_place,
            .bic_delta = -2.0 * p.ahead_nats,
            .residual_rms_before = NAN,
            .residual_rms_after = NAN};
  return f;
}

namespace {

std::string failed_a(const PlaceCheck& p) {
  if (p.ahead) return {};
  return fmt::format("{} explains the readings {} ({} {}; {} would decide)", p.rival,
                     p.ahead_nats > -kDecided ? "about as well" : "better",
                     nats(std::abs(p.ahead_nats)), p.ahead_nats < 0.0 ? "ahead" : "behind",
                     kDecided);
}

std::string failed_b(const Diagnosis& d) {
  if (d.place->stays) return {};
  const AtRest rest = d.field_at_rest.value_or(AtRest{});
  if (rest.rests == 0) return "no rest shows that the departure stays while the sensor does";
  return fmt::format(
      "while the sensor rested, {:.0f} to {:.0f} s{}, the departure changed by {:.2g} uT ({:.0f} "
      "standard deviations)",
      rest.begin_s, rest.end_s, d.recordings.size() > 1 ? " of " + rest.recording : "",
      rest.change_uT, rest.change_sigmas);
}

std::string failed_c(const PlaceCheck& p) {
  if (p.comes_back) return {};
  if (p.blocks == 0) return "the recording is too short to leave 20 s out";
  if (p.predicts_nats() > kDecided) {
    return fmt::format(
        "a function of the place predicts what was left out better by {}, which is little beside "
        "the {} that are missing in the field",
        nats(p.predicts_nats()), nats(p.process_nats));
  }
  return fmt::format(
      "{} blocks of {:.0f} s that were left out are predicted {} {} by a function of the place "
      "than without one (more than {} better would decide)",
      p.blocks, p.block_s, nats(std::abs(p.predicts_nats())),
      p.predicts_nats() < 0.0 ? "worse" : "better", kDecided);
}

}  // namespace

std::string why_no_place(const Diagnosis& d) {
  const std::string a = failed_a(*d.place), b = failed_b(d), c = failed_c(*d.place);
  std::string why;
  for (const std::string& part : {a, b, c}) {
    if (!part.empty()) why += (why.empty() ? "" : "; ") + part;
  }
  std::string settle;
  if (!b.empty()) {
    settle = "lay the sensor down for ten seconds at two or three places";
  }
  if (!a.empty() || !c.empty()) {
    settle += std::string(settle.empty() ? "" : ", and ") +
              "move it to and fro between the same places, half a metre apart, in other attitudes";
  }
  return "That the field differs from place to place is not shown: " + why + ". To settle it, " +
         settle + ".";
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/scan/missing_effects.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "calibration/fit/side_by_side.h"
#include "calibration/fit/uncertainty.h"
#include "calibration/model/parameter_names.h"
#include "calibration/model/windows.h"
#include "calibration/motion/random_walk.h"
#include "calibration/scan/change_search.h"
#include "calibration/scan/general_dependence.h"
#include "calibration/scan/scan.h"
#include "calibration/scan/testable.h"
#include "calibration/scan/unseen_tolerances.h"
#include "factors/effects/catalogue.h"
#include "graph/decompositions.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kFalseAlarms = 0.05;  // of all tests together, where nothing is missing
constexpr double kBiasWindow = 10.0;   // s, in which a bias may be another one
constexpr int kMaxWindows = 12;
constexpr int kColumnsAtOnce = 64;       // of candidates, in a long recording
constexpr double kBeyondOneStep = 0.02;  // of a shift
constexpr double kStronglyColoured = 2.0;
constexpr double kWidened = 3.0;  // priors of effects: what is there may be larger than usual
// Of a cause without a name: as much as is seen and more may look like the calibration itself. The
// shift counts as a standard deviation three times as large.
constexpr double kHiddenToo = 3.0;

// Is it this effect, one of its class, or one that contains it?
bool concerns(const Effect& effect, const std::string& name) {
  const auto has = [&](const std::vector<std::string>& names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  return effect.name() == name || has(effect.description().contains) ||
         has(effect.description().same_class);
}

std::vector<std::shared_ptr<const Effect>> candidates(
    const std::vector<const Recording*>& recordings, const Stage& stage) {
  std::vector<std::shared_ptr<const Effect>> out = testable_effects(recordings, stage);
  // What the model has already, and what contains that: the two would share one parameter.
  std::erase_if(out, [&](const auto& effect) {
    return (stage.spec().mag_time_offset && concerns(*effect, "mag_time_offset")) ||
           (stage.spec().gyr_matrix &&
            (effect->name() == "gyro_scale_misalignment" || effect->name() == "clock_scale"));
  });
  return out;
}

// A family of tolerances that is not seen to be missing. influence: by how much its parameters move
// the calibration's.
struct ToleranceFamily {
  std::string name;
  Sensor channel = Sensor::kAcc;
  ToleranceDirections directions;
  MatrixXd influence;
};

std::vector<MissingEffect> unseen_of(const std::vector<ToleranceFamily>& families) {
  std::vector<ToleranceDirections> directions;
  for (const ToleranceFamily& f : families) directions.push_back(f.directions);
  const std::vector<MatrixXd> sizes = unseen_tolerances(directions);
  std::vector<MissingEffect> out;
  for (std::size_t i = 0; i < families.size(); ++i) {
    const MatrixXd& influence = families[i].influence;
    MissingEffect& unseen = out.emplace_back();
    unseen.name = families[i].name;
    unseen.channel = families[i].channel;
    unseen.shift = VectorXd::Zero(influence.rows());
    unseen.covariance = influence * sizes[i] * influence.transpose();
  }
  return out;
}

struct FoundByScan {
  std::vector<MissingEffect> missing;
  std::optional<BiasStep> step;
  std::vector<ToleranceFamily> families;
};

// What one scan says of the calibration, candidate by candidate.
class Search {
 public:
  Search(const std::vector<const Recording*>& recordings, const Stage& stage, double log10_level)
      : recordings_(recordings), stage_(stage), log10_level_(log10_level) {
    for (const NodePlan& plan : stage.plans()) seconds_ += plan.t.back() - plan.t.front();
    for (const double square : stage.mag_squares()) squares_ += square;
    const std::vector<double> in_uT = stage.mag_squares_uT();
    const double nodes = double(in_uT.size()), per_s = nodes / std::max(seconds_, 1e-9);
    for (const double square : in_uT) mean_square_uT_ += square * per_s;
    mean_square_uT_ /=
        3.0 * nodes * double(std::max<std::size_t>(1, recordings.front()->mag.size()));
  }

  // With many nodes, few candidates at a time: the information of each window grows with the square
  // of the candidates' columns.
  void look(const std::vector<std::shared_ptr<const Effect>>& effects) {
    const bool many = are_many(stage_.plans());
    for (std::size_t begin = 0, end = 0; begin < effects.size(); begin = end) {
      int columns = 0;
      for (; end < effects.size(); ++end) {
        columns += effects[end]->size();
        if (many && end > begin && columns > kColumnsAtOnce) break;
      }
      const std::vector<std::shared_ptr<const Effect>> own(effects.begin() + std::ptrdiff_t(begin),
                                                           effects.begin() + std::ptrdiff_t(end));
      const Scan scan(recordings_, stage_, own,
                      window_s(own.front()->channel(), stage_.spec().motion));
      for (std::size_t i = 0; i < own.size(); ++i) look_at(scan, i, *own[i]);
    }
  }
  FoundByScan found() && { return std::move(found_); }

 private:
  void look_at(const Scan& scan, std::size_t i, const Effect& effect) {
    const Score s = scan.with_own_scatter(i);
    const ChangeEffect* const change = as_change(effect);
    // What comes and goes is not the device.
    const bool passes = change != nullptr && change->span().end.finite();
    const bool missing = !passes && is_missing(scan, i, effect, s);
    if (!missing && !passes) look_for_unseen(scan, i, effect, s);
    if (change != nullptr && change->channel() == Sensor::kMag) keep_step(*change, s, missing);
  }
  // By how much each of the effect's parameters moves the calibration's.
  MatrixXd influence_of(const Scan& scan, std::size_t i, const Effect& effect) const {
    MatrixXd out = scan.influence().middleCols(scan.first(i), effect.size());
    out.middleRows(first_dip(), dips()) /= kDegree;
    // Of what the model has already the sum is told: what was estimated and what is unseen, which
    // take from each other.
    const auto names =
        parameter_names(int(recordings_.front()->mag.size()), int(dips()), stage_.spec());
    const auto own = std::ranges::find(names, effect_parameter_name(effect, 0));
    if (own != names.end()) {
      out.middleRows(own - names.begin(), effect.size()) +=
          MatrixXd::Identity(effect.size(), effect.size());
    }
    return out;
  }
  void keep_step(const ChangeEffect& change, const Score& s, bool beyond_chance) {
    const ChangeSpan& span = change.span();
    if (!span.begin.finite()) return;
    found_.step = {.begin_s = span.begin.t,
                   .within_s = window_of(change),
                   .by = s.theta.head<3>(),
                   .share_of_misfit = s.statistic / std::max(squares_, 1e-30),
                   .beyond_chance = beyond_chance};
    if (span.end.finite()) found_.step->end_s = span.end.t;
  }
  void look_for_unseen(const Scan& scan, std::size_t i, const Effect& effect, const Score& s) {
    if (!is_tolerance(effect)) return;
    const VectorXd z = scan.score().segment(scan.first(i), effect.size());
    found_.families.push_back(
        {effect.name(), effect.channel(),
         tolerance_directions(s.information, z, s.coloured ? s.scatter : 1.0,
                              effect.prior_sigma(recordings_.front()->duration_s())),
         influence_of(scan, i, effect)});
  }
  bool is_missing(const Scan& scan, std::size_t i, const Effect& effect, const Score& s) {
    const bool named = find_effect(effect.name()) != nullptr, coloured = s.coloured;
    // Strongly coloured noise has little dependences on everything; the robust covariance knows.
    if (!named && s.scatter > kStronglyColoured) return false;
    const double excess = coloured ? s.scatter : 1.0, duration = recordings_.front()->duration_s();
    const VectorXd z = scan.score().segment(scan.first(i), effect.size());
    VectorXd prior = kWidened * effect.prior_sigma(duration);
    const ChangeEffect* const change = as_change(effect);
    double log10_p = s.log10_p + (change != nullptr ? log10_of_times(*change) : 0.0);
    double wandered = 0.0;
    if (effect.description().random_process) {
      const RandomWalk walk = estimate_random_walk(s.information, z, prior / kWidened, excess);
      log10_p = walk.log10_p;
      prior *= std::max(walk.density, 1e-12) / kWidened;
      // A bias that wanders is somewhere else at another time.
      wandered = walk.density * walk.density * duration / 3.0;
    }
    if (log10_p > log10_level_) return false;
    // What the motion does not show is no more uncertain than it was: the model has it already.
    const MatrixXd& P = s.visible;
    const MatrixXd weight = prior.cwiseAbs2().cwiseInverse().asDiagonal();
    MatrixXd A = P.transpose() * weight * P;
    A.diagonal().array() += 1.0 / excess;
    const MatrixXd posterior = P * A.ldlt().solve(MatrixXd(P.transpose()));
    // A direction that the calibration and the attitudes all but imitate has next to no information
    // of its own: what a model of few nodes approximates shows there as a score of many sigmas, and
    // asks for an effect a thousand times its usual size. So the gain counts that the effect makes
    // at its prior scale, z' (A + W)^-1 z. That is at most the score statistic z' A^-1 z, whose
    // distribution under no effect therefore bounds it.
    if (!effect.description().random_process &&
        log10_chi_square_tail(z.dot(posterior * z) / excess, s.dof) > log10_level_) {
      return false;
    }
    const MatrixXd influence = influence_of(scan, i, effect);
    MissingEffect found;
    found.name = named ? effect.name() : "";
    found.channel = effect.channel();
    found.cause = effect.description().cause;
    found.log10_p = log10_p;
    found.share_of_misfit = s.statistic / std::max(squares_, 1e-30);
    found.needs = effect.description().needs;
    if (!named && effect.channel() == Sensor::kMag) {
      found.seen_uT = std::sqrt(std::min(1.0, found.share_of_misfit) * mean_square_uT_);
    }
    found.shift = influence * (posterior * z) / excess;
    found.covariance = influence * posterior * influence.transpose();
    found.covariance.diagonal().segment<3>(3).array() += wandered;
    if (change != nullptr) {
      // There were two biases, and the calibration has one.
      const Vector3 other = (posterior * z) / excess;
      const Eigen::Index bias = first_of_bias(effect.channel());
      found.covariance.block<3, 3>(bias, bias) += other * other.transpose();
    }
    found_.missing.push_back(std::move(found));
    return true;
  }
  // Of the number of times that were tried.
  double log10_of_times(const ChangeEffect& change) const {
    return std::log10(lasting_spans(int(std::ceil(seconds_ / window_of(change)))));
  }
  double window_of(const ChangeEffect& change) const {
    return change_window_s(stage_.plans(), change.channel(), stage_.spec().motion);
  }
  Eigen::Index first_dip() const { return 6 + 12 * Eigen::Index(recordings_.front()->mag.size()); }
  Eigen::Index dips() const { return Eigen::Index(field_count(recordings_)); }

  const std::vector<const Recording*>& recordings_;
  const Stage& stage_;
  double log10_level_, seconds_ = 0.0;
  double squares_ = 0.0, mean_square_uT_ = 0.0;  // of the magnetometers, of one reading's axis
  FoundByScan found_;
};

// Of the effects on one sensor.
FoundByScan look(const std::vector<const Recording*>& recordings, const Stage& stage,
                 const std::vector<std::shared_ptr<const Effect>>& effects, double log10_level) {
  if (effects.empty()) return {};
  Search search(recordings, stage, log10_level);
  search.look(effects);
  return std::move(search).found();
}

// What the scans of these effects say. Each sensor's by themselves: a candidate's test takes no
// notice of the others, and columns cost their square.
SearchedEffects searched(const std::vector<const Recording*>& recordings, const Stage& stage,
                         const std::vector<std::shared_ptr<const Effect>>& all) {
  const double log10_level = std::log10(kFalseAlarms / double(all.size()));
  std::array<FoundByScan, 3> found;
  const auto look_at = [&](std::size_t channel) {
    std::vector<std::shared_ptr<const Effect>> own;
    std::ranges::copy_if(all, std::back_inserter(own),
                         [&](const auto& e) { return std::size_t(e->channel()) == channel; });
    found[channel] = look(recordings, stage, own, log10_level);
  };
  side_by_side(
      stage.plans(), [&] { look_at(0); }, [&] { look_at(1); }, [&] { look_at(2); });
  SearchedEffects out;
  std::vector<ToleranceFamily> families;
  for (const FoundByScan& own : found) {
    out.missing.insert(out.missing.end(), own.missing.begin(), own.missing.end());
    families.insert(families.end(), own.families.begin(), own.families.end());
    if (own.step) out.step = own.step;
  }
  out.unseen = unseen_of(families);
  return out;
}

// Variances, in the order of the covariance, of what looks like the calibration itself in a cause
// of which so much is seen beside it. Nothing is known of such a cause, so that it may be as large
// in one function of the attitude as in another; those of the calibration are a constant (the
// bias), the field's components (D), and their turn about the east (the dip).
VectorXd hidden_part(const Calibration& c, double seen_uT) {
  VectorXd out = VectorXd::Zero(c.covariance.rows());
  const auto mags = Eigen::Index(c.parameters.mag.size());
  out.segment(6, 12 * mags).setConstant(seen_uT * seen_uT);
  out.segment(6 + 12 * mags, Eigen::Index(c.fields.size()))
      .setConstant(std::pow(seen_uT / (c.strength_uT * kDegree), 2));
  return out;
}

// The parameters whose sigmas are most of all the doubt: "its bias", "0.07 m/s^2".
struct Doubted {
  std::string what, size;
  double ratio = 0.0;  // of the doubt's variance over that without it, at most
};
Doubted most_doubted(const Calibration& c, const MatrixXd& without, const MatrixXd& doubt) {
  struct Group {
    const char *what, *unit;
    Eigen::Index first, size;
  };
  const auto mags = 12 * Eigen::Index(c.parameters.mag.size());
  const Group groups[] = {{"accelerometer's bias", "m/s^2", 0, 3},
                          {"gyroscope's bias", "rad/s", 3, 3},
                          {"magnetometer's distortion and bias", "uT", 6, mags},
                          {"dip", "deg", 6 + mags, Eigen::Index(c.fields.size())}};
  Doubted out;
  for (const Group& g : groups) {
    double ratio = 0.0, largest = 0.0;
    for (Eigen::Index i = g.first; i < g.first + g.size; ++i) {
      ratio = std::max(ratio, doubt(i, i) / std::max(without(i, i), 1e-300));
      largest = std::max(largest, doubt(i, i));
    }
    if (ratio > out.ratio) {
      out = {g.what, fmt::format("{:.2g} {}", std::sqrt(largest), g.unit), ratio};
    }
  }
  return out;
}

std::string in_words(const MissingEffect& f) {
  if (!f.name.empty()) return f.cause;
  return fmt::format("the {} depends {}", in_words(f.channel), f.cause);
}

}  // namespace

SearchedEffects search_effects(const std::vector<const Recording*>& recordings,
                               const Stage& stage) {
  const bool moving = is_moved(stage.spec().motion);
  std::vector<std::shared_ptr<const Effect>> all = candidates(recordings, stage);
  for (const auto& unnamed : general_dependences(moving)) {
    // Of the accelerometer the hand's motion takes up much, and shapes what is left.
    if (!moving || unnamed->channel() != Sensor::kAcc) all.push_back(unnamed);
  }
  if (field_count(recordings) == 1) {
    double length = 0.0;
    for (const Recording* part : recordings) length += part->duration_s();
    const int windows = std::clamp(int(length / kBiasWindow), 2, kMaxWindows);
    all.push_back(bias_in_windows(windows));
    all.push_back(bias_in_windows(windows, Sensor::kGyr));
    for (const LikelyChange& change : changes_of_bias(recordings, stage)) {
      all.push_back(change.effect());
    }
  }
  return searched(recordings, stage, all);
}

std::vector<MissingEffect> search_unseen(const std::vector<const Recording*>& recordings,
                                         const Stage& stage) {
  std::vector<std::shared_ptr<const Effect>> all = candidates(recordings, stage);
  std::erase_if(all, [](const auto& effect) { return !is_tolerance(*effect); });
  return searched(recordings, stage, all).unseen;
}

void add_missing_effects(Calibration& c, const std::vector<MissingEffect>& found) {
  const Eigen::Index p =
      6 + 12 * Eigen::Index(c.parameters.mag.size()) + Eigen::Index(c.fields.size());
  const Eigen::LDLT<MatrixXd> V(MatrixXd(c.covariance.topLeftCorner(p, p)));
  Check check{"model", CheckStatus::kOk, 0.0, "Nothing is seen to be missing in the model."};
  MatrixXd more = MatrixXd::Zero(c.covariance.rows(), c.covariance.cols());
  double seen_uT = 0.0;
  const MatrixXd without = c.covariance;
  const MissingEffect* farthest = nullptr;
  for (const MissingEffect& f : found) {
    const VectorXd shift = f.shift.head(p);
    const double distance = std::sqrt(std::max(0.0, shift.dot(V.solve(shift))));
    // One step of a refit is not the refit: of a large shift a part lies elsewhere.
    more += std::pow(kBeyondOneStep * distance, 2) * c.covariance;
    const double hidden = f.name.empty() ? kHiddenToo : 1.0;
    more += hidden * hidden * f.shift * f.shift.transpose() + f.covariance;
    check.status = CheckStatus::kCaution;
    if (farthest == nullptr || distance > check.value) farthest = &f;
    check.value = std::max(check.value, distance);
    seen_uT = std::max(seen_uT, f.seen_uT);
  }
  if (!found.empty()) {
    // Each was tried alone, and one cause shows in others' tests, too.
    const Doubted most = most_doubted(c, without, farthest->shift * farthest->shift.transpose());
    const MissingEffect& plainest = *std::ranges::min_element(found, {}, &MissingEffect::log10_p);
    const std::string causes =
        found.size() == 1
            ? "what would explain it is that " + in_words(plainest)
            : fmt::format("{} causes would each explain some of it, that {} among them",
                          found.size(), in_words(plainest));
    check.sentence = fmt::format(
        "Something is missing in the model; {}. With that the {} would be another by up to {}, "
        "{:.1f} standard deviations of what noise alone leaves unknown. The sigmas given here were "
        "widened by it{}, and contain it; what looks like the calibration itself no recording "
        "shows, and it may be more. `magimu diagnose` finds out which cause it is.",
        causes, most.what, most.size, check.value,
        seen_uT > 0.0 ? fmt::format(" and by the {:.2g} uT that are seen of it", seen_uT) : "");
  }
  c.checks.push_back(check);
  if (seen_uT > 0.0) more.diagonal() += hidden_part(c, seen_uT);
  if (!found.empty()) add_to_covariance(c, more);
}

MatrixXd add_unseen_tolerances(Calibration& c, const std::vector<MissingEffect>& unseen) {
  Check check{"tolerances", CheckStatus::kOk, 0.0,
              "The motion tells the errors that parts usually have from the calibration."};
  const MatrixXd without = c.covariance;
  MatrixXd more = MatrixXd::Zero(without.rows(), without.cols());
  for (const MissingEffect& u : unseen) {
    more += u.covariance;
    const Doubted most = most_doubted(c, without, u.covariance);
    if (!(most.ratio > std::max(1.0, check.value))) continue;
    const std::shared_ptr<const Effect> effect = find_effect(u.name);
    check = {
        "tolerances", CheckStatus::kCaution, most.ratio,
        fmt::format("This motion does not show whether {}. By as much as parts usually have of "
                    "that, the {} may be off by {} (one standard deviation, which the sigmas "
                    "contain). To be sure, {}.",
                    effect->description().cause, most.what, most.size,
                    effect->description().separating_motion)};
  }
  c.checks.push_back(check);
  if (unseen.empty()) return more;
  c.covariance_model += more;
  c.covariance_common = more;
  add_to_covariance(c, more);
  return more;
}

}  // namespace magimu

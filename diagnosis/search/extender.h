// SPDX-License-Identifier: BSD-3-Clause
// The extension of a model by effects, one after another: scan; refit the best candidates; of those
// that predict left-out data better than the model without them accept the most likely one; scan
// again. Where none passes by itself, look for two that hide each other (extender_pairs.cpp). What
// has entered is tested again beside what came later (extender_revision.cpp).
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <set>

#include "calibration/fit/disturbances/disturbance.h"
#include "calibration/motion/random_walk.h"
#include "calibration/pipeline.h"
#include "diagnosis/result/diagnosis.h"
#include "diagnosis/search/doubts.h"
#include "diagnosis/search/option.h"

namespace magimu {

class ChangeEffect;
class ChangeFit;

class Extender {
 public:
  // whole: the recordings as given, with long rests and all samples. All must outlive this.
  // Findings and the scan go into d.
  Extender(const std::vector<const Recording*>& recordings,
           const std::vector<const Recording*>& whole, const Pipeline& pipeline,
           const DiagnosisOptions& options, Diagnosis& d);

  // Extends the model of this stage until nothing more passes.
  void extend(const Stage& from);
  // A better model found elsewhere is the stage from now on.
  void replace(const Stage& stage);
  // Effects whose finding was withdrawn leave the model.
  void keep_named();
  // Gives the findings the parameters that they have in the final model. after: stage()'s summary.
  void restate(const Calibration& after);
  // Candidates that could be tested under this model, and the scan of them; nothing is accepted.
  std::vector<std::shared_ptr<const Effect>> candidates(const Stage& stage) const;

  // stage() fitted without one of its effects (nothing where its numbers fail), and by how many
  // nats the effect explains more than chance does in as many parameters; with a random process'
  // states integrated out.
  std::optional<Stage> without(std::size_t effect) const;
  double worth(std::size_t effect, const Stage& without) const;

  void set_base(const Stage& stage) { base_ = stage; }
  const Stage& base() const { return *base_; }    // the model that the diagnosis started from
  const Stage& stage() const { return *stage_; }  // the model as extended so far
  // Did a change of this sensor explain most of what there was, whether it was named or refused?
  bool may_have_changed(Sensor sensor) const { return may_have_changed_.contains(sensor); }
  // log10 of the level that one test among all must pass.
  double log10_level() const;

  Calibration summary(const Stage& stage) const;

 private:
  static constexpr double kMinGain = 1.0;  // nats on left-out data
  static constexpr int kTried = 4;         // best candidates that are refitted

  struct Trial {
    Option option;
    Stage stage;
    double nll;
    bool coloured;    // under noise that is not white
    double left_out;  // nats that left-out data gain, windows or whole quarters
    // G, nats, beside the model with the option, of the process that gains most without it.
    double left = 0.0;
    // Nats on all data over the model without the option; the same beside that process.
    double alone = 0.0, gain = 0.0;

    VectorXd parameters() const;
  };
  KnownScatter excess(Sensor channel, const Stage& stage) const;
  bool is_rounding(const Option& option, const Stage& stage) const;
  bool survives(Option& option, const Stage& stage, const Score& w) const;
  double log10_p_by_blocks(const Stage& stage) const;
  bool explains_most(const Stage& with) const;
  bool explains_most_of_two(const Stage& with) const;
  bool is_hopeless(const Option& option, const Stage& stage) const;
  bool stands_out(const Option& option, const Stage& stage, double statistic) const;
  bool is_all(const Stage& stage) const;
  bool is_put_down(const Moment& at) const;
  bool passes_by(const Option& option, const Stage& stage) const;
  // A stage whose left-out data are predicted; its refit, if one was needed, is kept.
  struct LeftOut {
    const Stage& stage;
    std::optional<Stage> refitted;
  };
  double gain(LeftOut& left_out, std::optional<double> window_s = {}) const;
  double quarter_s() const;
  void judge_beside_process(std::vector<Trial>& trials) const;
  static bool stands_beside_process(const Trial& trial);
  bool enough_beyond(const Option& option, double gain) const;
  // may_refit: whether times of a change may be sought by refits; false after they have been.
  std::optional<Trial> trial(Option option, bool& may_refit, std::optional<Option>& most) const;
  // Nats on all data that an effect gains over a model that lacks it, less one for each parameter
  // (the gain by chance) and less `searched` (Option::searched). A random process: with its states
  // integrated out.
  double explains(const Stage& with, std::size_t effect, const Stage& without,
                  double searched) const;
  double likelier(const Trial& trial) const;
  std::vector<Trial> trials(const std::vector<Option>& options);
  bool was_refused(const Option& option) const;
  static const Trial* best_of(const std::vector<Trial>& trials);
  std::vector<Option> worth_trying(const std::vector<Option>& options) const;
  std::optional<Finding> try_options(const std::vector<Option>& options);
  std::vector<Option> firsts_of_pairs(const std::vector<Option>& options) const;
  bool try_pairs(const std::vector<Option>& options);
  bool predicts_better_than(const Stage& stage, double nll) const;
  bool try_beside(const Option& first, const Stage& alone);
  Finding describe(const Option& option, const Stage& stage, double nll,
                   const std::vector<Option>& all, const VectorXd& least_sigma) const;
  void add_times(const ChangeSpan& span, const std::array<double, 2>& sigma_t, Finding& f) const;
  bool find_times(Option& option, Stage& stage, bool& may_refit) const;
  void find_source(Option& option, Stage& stage) const;
  void prune();
  void reconsider();
  void estimate_walk_anew();
  RandomWalk walk_in(const Stage& stage, std::size_t effect) const;
  bool name_simpler(std::size_t finding, std::shared_ptr<const Effect> named);
  void refine_changes();
  // The end where it is not named.
  std::vector<Finding>::iterator finding_of(const ChangeEffect& change);
  void set_change(const ChangeFit& fit, Finding& finding);
  bool one_of_two_changes_is_enough(std::size_t one, std::size_t other);
  bool one_change_for(const std::vector<std::shared_ptr<const Effect>>& replaced,
                      const std::string& name, ChangeForm form, const ChangeSpan& span);
  bool name_third_sensor(std::size_t one, std::size_t other);
  bool name_complement(std::size_t change, std::size_t throughout);
  bool name_one_change();
  bool name_lasting(const std::shared_ptr<const Effect>& named);
  void join_changes();
  bool name_one_for_two(std::size_t first, std::size_t second);
  void take(const Stage& stage, double nll);

  const std::vector<const Recording*>& recordings_;
  const std::vector<const Recording*>& whole_;
  const Pipeline& pipeline_;
  const DiagnosisOptions& given_;
  Diagnosis& d_;
  SlowNoise at_rest_;
  double step_uT_ = 0.0;                                // of a coarse magnetometer
  std::array<double, 3> in_samples_ = {1.0, 1.0, 1.0};  // excess_of_samples
  std::optional<Stage> base_, stage_;
  double nll_ = 0.0;
  bool refits_spent_ = false;                      // on the times of a change; of this model
  mutable std::mutex refitting_;                   // trials stand side by side
  mutable std::optional<Stage> refitted_;          // stage_, its noise estimated once more
  mutable std::vector<DisturbanceFit> processes_;  // beside stage_; empty: not asked for yet
  std::vector<Option> refused_changes_;            // whose times were sought, each with many fits
  // Changes that were refused, with their times, though they explain most of what there is, alone
  // or with another change.
  std::vector<Option> explain_most_;
  std::set<Sensor> may_have_changed_;  // of all models since extend() began
  std::vector<std::string> rejected_;  // looked significant, predicts no better
  std::vector<std::string> expelled_;  // entered, and were not needed beside the others
  struct Entered {
    VectorXd apart;         // distance of other parameters of it that are about as likely
    double searched = 0.0;  // Option::searched
  };
  std::map<std::string, Entered> entered_;  // by the effect's name
};

}  // namespace magimu

// SPDX-License-Identifier: MIT
#include "trainer/app/commands/feedback_rounds.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>

#include "trainer/app/jobs/run_jobs.h"
#include "trainer/app/terminal/progress.h"
#include "trainer/base/number_text.h"
#include "trainer/base/printable.h"
#include "trainer/choose/left_out.h"
#include "trainer/experiments/training_sets.h"

namespace nlo::trainer {
namespace {

/// Shows the progress of a training on stderr, unless quiet.
class TrainingDisplay {
 public:
  TrainingDisplay(const Experiment& experiment, const Dataset& training, bool quiet) : experiment_(experiment) {
    if (quiet) return;
    say_units(training);
    line_.emplace(stderr);
  }

  void update(const TrainProgress& progress) {
    if (line_) line_->update(progress);
  }

  /// Begins another training: one without some of the logs, or the training on all of them.
  void begin(const std::string& training) {
    if (!line_) return;
    line_->finish();
    fmt::print(stderr, "{}\n", printable(training));
    line_.emplace(stderr);
  }

  void finish(const TrainingResult& result) {
    if (!line_) return;
    line_->finish();
    if (result.returns > 0)
      fmt::print(stderr,
                 "note: training diverged {} time{} and continued from its best model; a lower learning_rate (now {}) "
                 "may help\n",
                 result.returns, result.returns == 1 ? "" : "s", shortest_text(experiment_.training.learning_rate));
  }

 private:
  /// Explains the RMSE of the progress if the states have different units.
  void say_units(const Dataset& training) const {
    if (experiment_.loss.is_normalised())
      fmt::print(stderr, "rmse: the error of each state is divided by its standard deviation, as in the loss\n");
    else if (!share_a_unit(training.states))
      fmt::print(stderr,
                 "rmse: sums the errors of states in different units, as the loss does; [loss] scale = \"normalised\" "
                 "gives all states the same weight\n");
  }

  const Experiment& experiment_;
  std::optional<ProgressDisplay> line_;
};

TrainingResult run_round(const Experiment& experiment, const RunData& data, const std::string& directory,
                         const RoundsOptions& rounds) {
  TrainingDisplay display(experiment, data.training, rounds.quiet);
  TrainOptions options;
  options.directory = directory;
  options.resume = rounds.resume;
  options.stop = &stop_on_interrupt();
  options.facts = rounds.facts;
  if (!rounds.quiet) options.progress = [&](const TrainProgress& progress) { display.update(progress); };
  TrainingResult result = train_with_folds(experiment, data.training, data.choosing(), options,
                                           [&](const std::string& training) { display.begin(training); });
  display.finish(result);
  return result;
}

/// Adds the runs of a round, in the loop of the observer of the last round.
void enter_loop(const Experiment& experiment, int round, const codegen::Model& observer, RunData& data) {
  TrainingSets sets = next_round(experiment, {round, &observer}, {std::move(data.training), {}});
  data.training = std::move(sets.training);
  data.validation = std::move(sets.validation);
  print_warnings(sets.warnings);
}

}  // namespace

TrainingResult run_rounds(const Experiment& experiment, RunData& data, const RunFolder& folder,
                          const RoundsOptions& options) {
  if (!options.resume) folder.forget_rounds();
  const int last = folder.last_round();
  TrainingResult result;
  for (int round = 0; round <= last; ++round) {
    if (round > 0) enter_loop(experiment, round, result.model, data);
    if (last > 0 && !options.quiet)
      fmt::print(stderr, "round {} of {}: {} runs, in the loop of {}\n", round, last, data.training.trajectories.size(),
                 round == 0 ? "the true state" : fmt::format("round {}'s observer", round - 1));
    const bool resume = options.resume && folder.has_begun(round);
    result = run_round(experiment, data, folder.of_round(round), {resume, options.quiet, options.facts});
    if (result.outcome == TrainOutcome::kInterrupted || result.outcome == TrainOutcome::kDiverged) break;
  }
  return result;
}

}  // namespace nlo::trainer

// SPDX-License-Identifier: MIT
#include "trainer/app/commands/auto_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <utility>

#include "codegen/base/file.h"
#include "trainer/app/commands/command.h"
#include "trainer/app/commands/model_cost.h"
#include "trainer/app/commands/output_directory.h"
#include "trainer/app/commands/patient_progress.h"
#include "trainer/app/jobs/finished_run.h"
#include "trainer/app/jobs/kept_training.h"
#include "trainer/app/jobs/run_jobs.h"
#include "trainer/app/sweep/search.h"
#include "trainer/base/draws.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/learn/training/provenance.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {
namespace {

namespace fs = std::filesystem;
using Time = std::chrono::steady_clock::time_point;

Time now() {
  return std::chrono::steady_clock::now();
}

double seconds(Time from, Time to) {
  return std::chrono::duration<double>(to - from).count();
}

void check_interrupt() {
  if (stop_on_interrupt().load()) throw RunFailure("interrupted");
}

class Search {
 public:
  Search(const SearchTask& task, const SearchBudget& budget, std::string directory, bool quiet)
      : task_(task),
        budget_(budget),
        directory_(std::move(directory)),
        quiet_(quiet),
        judge_(task.experiment, task.data.choosing()) {
    const std::uint64_t data = training_data_hash(task.data.training, task.data.choosing());
    const std::string text = fmt::format("{} {} {} {} {}", run_identity(task.experiment), data, budget.minutes,
                                         budget.multiply_adds, budget.flash_bytes);
    record_.identity = fingerprint(text.data(), text.size());
  }

  SearchRecord run(bool resume) {
    if (resume) read();
    if (record_.candidates.empty()) draw();
    const double reserved_s = record_.by_hand_fits() ? record_.by_hand_s : 0.0;
    const std::vector<Rung> rungs = halving_rungs(record_.candidates.size(), record_.seconds - reserved_s);
    for (std::size_t r = 0; r < rungs.size(); ++r) {
      if (r >= record_.rungs.size()) begin_rung(rungs[r], r + 1 == rungs.size());
      // The trainings of a rung run one after another, because their measured speed determines the next rung.
      const bool last = r + 1 == rungs.size();
      std::vector<Job> trainings;
      for (Trial& trial : record_.rungs[r])
        trainings.push_back({fmt::format("rung {} of {}, training {} of {}", r + 1, rungs.size(), trainings.size() + 1,
                                         record_.rungs[r].size()),
                             1.0, [&, last](const JobContext& context) { return perform(trial, last, context); }});
      const JobsResult ran = run_jobs(trainings, {.side_by_side = false, .stop = &stop_on_interrupt()});
      ran.check();
      if (ran.left > 0) throw RunFailure("interrupted");
    }
    progress_.finish();
    std::error_code ignored;
    fs::remove_all(jobs(), ignored);
    const std::vector<Trial>& last = record_.rungs.back();
    if (std::none_of(last.begin(), last.end(), [](const Trial& trial) { return trial.error.has_value(); }))
      throw RunFailure(
          "every training of the last rung diverged or did not improve its initial model; give more --minutes or a "
          "lower "
          "learning_rate");
    const Trial& chosen = record_.chosen();
    if (!record_.by_hand_fits() && chosen.steps < least_steps()) refuse_time(chosen.candidate);
    return std::move(record_);
  }

 private:
  std::string jobs() const { return directory_ + "/auto"; }
  std::string file() const { return directory_ + "/auto.json"; }

  void save() const { codegen::write_file_atomically(file(), to_json(record_)); }

  void read() {
    std::error_code ignored;
    if (!fs::exists(file(), ignored)) return;
    SearchRecord found = search_record_from_json(codegen::read_file(file()), file());
    if (found.identity != record_.identity)
      throw codegen::InputError(
          fmt::format("{}: this search belongs to another experiment, budget or data; choose another -o DIR, or start "
                      "again without --resume",
                      file()));
    record_ = std::move(found);
  }

  /// Returns true if the given experiment is candidate 0. An experiment that costs too much is no candidate.
  bool stands() const { return record_.by_hand_s > 0.0; }

  /// Draws candidates that can be trained and keep to the budget.
  void draw() {
    const Time started = now();
    const double total_s = 60.0 * budget_.minutes, period_s = task_.data.training.sample_period_s;
    constexpr std::uint64_t kTries = 20;  // draws for each candidate
    constexpr double kShare = 0.2;        // share of the time for the draw; longer if few candidates are found by then
    constexpr std::size_t kFew = 4;
    std::size_t wanted = 1;
    for (std::uint64_t index = 0; record_.candidates.size() < wanted && index <= kTries * wanted; ++index) {
      if (record_.candidates.size() >= kFew && seconds(started, now()) > kShare * total_s) break;
      say(0.0, fmt::format("looking for candidates, {} found", record_.candidates.size()));
      const std::optional<Experiment> drawn = drawn_experiment(task_.experiment, period_s, index);
      const auto same = [&](const Candidate& other) { return other.experiment == drawn->source_text; };
      if (drawn && std::none_of(record_.candidates.begin(), record_.candidates.end(), same)) try {
          add(*drawn, index == 0);
        } catch (const codegen::Error&) {
          if (index == 0) throw;  // candidate 0 is the user's experiment, whose error must be reported
        }
      check_interrupt();
      if (index == 0) {
        const double setup_s = record_.candidates.empty() ? 0.0 : record_.candidates.front().setup_s;
        wanted = candidates_for(total_s - (2.0 * record_.by_hand_s <= total_s ? record_.by_hand_s : 0.0), setup_s);
      }
    }
    if (record_.candidates.empty())
      throw codegen::Error(
          fmt::format("every candidate exceeds the budget{}{}; allow more",
                      budget_.multiply_adds > 0 ? fmt::format(" --max-multiply-adds {}", budget_.multiply_adds) : "",
                      budget_.flash_bytes > 0 ? fmt::format(" --max-flash-bytes {}", budget_.flash_bytes) : ""));
    record_.seconds = std::max(total_s - seconds(started, now()), 0.5 * total_s);
    leave_out_slow();
    save();
  }

  double least_steps() const { return kLeastShareOfSteps * task_.experiment.training.steps; }

  /// Removes candidates that are so slow that the last rung would hardly train them. Throws if the given experiment is
  /// too slow, because the others are described by their differences from it.
  void leave_out_slow() {
    if (record_.by_hand_fits()) return;
    const double last_s = halving_rungs(record_.candidates.size(), record_.seconds).back().seconds;
    const auto slow = [&](const Candidate& c) { return steps_within(pace(c), last_s) < least_steps(); };
    const bool none = std::all_of(record_.candidates.begin(), record_.candidates.end(), slow);
    if (none || (stands() && slow(record_.candidates.front()))) refuse_time(0);
    std::erase_if(record_.candidates, slow);
  }

  [[noreturn]] void refuse_time(std::size_t candidate) const {
    throw TooLittleTime(fmt::format(
        "--minutes {:g} is too little: the result would be trained for less than {:.0f} of the experiment's {} steps, "
        "which is too few to compare candidates; give --minutes {:.0f} or more, or fewer steps in [training]",
        budget_.minutes, least_steps(), task_.experiment.training.steps,
        std::max(minutes_for(pace(record_.candidates[candidate]), least_steps()), std::ceil(1.2 * budget_.minutes))));
  }

  static TrainingPace pace(const Candidate& candidate) { return {candidate.setup_s, candidate.steps_per_s}; }

  /// Trains a few steps, to measure the speed of training and the cost in flight.
  void add(const Experiment& drawn, bool as_it_stands) {
    constexpr int kSteps = 24, kWarm = 4;
    Experiment experiment = drawn;
    set_steps(experiment, kSteps);
    const Time begun = now();
    Time warm, end;
    TrainOptions options;
    options.stop = &stop_on_interrupt();
    options.progress = [&](const TrainProgress& progress) {
      if (progress.step == kWarm) warm = now();
      end = now();
    };
    const CandidateData data(task_, experiment);
    const TrainingResult result = train(experiment, data.get().training, data.get().choosing(), options);
    if (result.steps_done < kSteps) return;
    const double steps_per_s = (kSteps - kWarm) / std::max(seconds(warm, end), 1e-6);
    const JobCost cost = model_cost(result.model);
    if ((budget_.multiply_adds > 0 && cost.multiply_adds > budget_.multiply_adds) ||
        (budget_.flash_bytes > 0 && cost.flash_bytes > budget_.flash_bytes))
      return;
    const Difference drawn_by = difference(task_.experiment, drawn);
    record_.candidates.push_back({drawn.source_text, drawn_by.full, drawn_by.title, cost, 0.0, steps_per_s});
    Candidate& added = record_.candidates.back();
    added.setup_s = std::max(seconds(begun, now()) - kSteps / steps_per_s, 0.0);
    if (as_it_stands) record_.by_hand_s = added.setup_s + static_cast<double>(drawn.training.steps) / steps_per_s;
  }

  void begin_rung(const Rung& rung, bool last) {
    std::vector<std::size_t> members;
    if (record_.rungs.empty()) {
      for (std::size_t c = 0; c < record_.candidates.size(); ++c) members.push_back(c);
    } else {
      const std::vector<Trial>& before = record_.rungs.back();
      std::vector<std::optional<double>> errors;
      for (const Trial& trial : before) errors.push_back(trial.error);
      for (const std::size_t place : best_of(errors, rung.candidates)) members.push_back(before[place].candidate);
      if (stands() && std::find(members.begin(), members.end(), 0U) == members.end()) members.push_back(0);
      std::sort(members.begin(), members.end());
    }
    if (members.empty()) throw RunFailure("every training of a rung diverged; give a lower learning_rate");
    std::vector<Trial>& trials = record_.rungs.emplace_back();
    for (const std::size_t member : members) trials.push_back({member, steps_of(member, rung, last)});
    save();
  }

  int steps_of(std::size_t member, const Rung& rung, bool last) const {
    constexpr double kMostLonger = 4.0;  // longest training, as a multiple of the experiment's steps
    const int by_hand = task_.experiment.training.steps;
    if (last && member == 0 && record_.by_hand_fits()) return by_hand;
    const double steps = std::round(rounded(steps_within(pace(record_.candidates[member]), rung.seconds)));
    return static_cast<int>(std::clamp(steps, 1.0, kMostLonger * by_hand));
  }

  JobEnd perform(Trial& trial, bool last, JobContext context) {
    if (trial.done) return JobEnd::kFound;
    Candidate& candidate = record_.candidates[trial.candidate];
    Experiment experiment = parse_experiment(candidate.experiment, file());
    experiment.threads = task_.experiment.threads;
    set_steps(experiment, trial.steps);
    context.progress = [&, before_s = done_s()](double share) {  // `share` is the finished share of the given time
      say((before_s + share * trial.steps / candidate.steps_per_s) / record_.seconds, context.name);
    };
    const std::string folder = fmt::format("{}/{}-{}", jobs(), record_.rungs.size() - 1, trial.candidate);
    make_output_directory(folder);
    try {
      const CandidateData data(task_, experiment);
      const TrainingResult result = resume_or_begin(folder, context, [&](const TrainOptions& options) {
        return train(experiment, data.get().training, data.get().choosing(), options);
      });
      if (result.outcome == TrainOutcome::kInterrupted) return JobEnd::kStopped;
      // Only the last rung requires a training that improves its start, as `nlo train` will when it trains the chosen
      // experiment again. The few steps of an early rung need not improve it.
      const bool counts = last ? result.succeeded() : result.outcome != TrainOutcome::kDiverged;
      if (counts) trial.error = judge_.error(result.model);
      if (result.elapsed_s > 0.0) candidate.steps_per_s = static_cast<double>(result.steps_done) / result.elapsed_s;
    } catch (const codegen::Error&) {
      trial.error.reset();  // the estimates overflowed
    }
    if (trial.error && !std::isfinite(*trial.error)) trial.error.reset();
    trial.done = true;
    save();
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    return JobEnd::kDone;
  }

  /// Returns the time [s] that the finished trials took, computed from the speeds known so far.
  double done_s() const {
    double sum = 0.0;
    for (const std::vector<Trial>& rung : record_.rungs)
      for (const Trial& trial : rung)
        if (const Candidate& candidate = record_.candidates[trial.candidate]; trial.done)
          sum += candidate.setup_s + trial.steps / candidate.steps_per_s;
    return sum;
  }

  void say(double share, const std::string& what) {
    if (!quiet_) progress_.update(std::min(share, 0.999), what);
  }

  const SearchTask& task_;
  SearchBudget budget_;
  std::string directory_;
  bool quiet_;
  SearchJudge judge_;
  SearchRecord record_;
  PatientProgress progress_;
};

}  // namespace

SearchRecord run_search(const SearchTask& task, const SearchBudget& budget, const std::string& directory, bool resume,
                        bool quiet) {
  return Search(task, budget, directory, quiet).run(resume);
}

}  // namespace nlo::trainer

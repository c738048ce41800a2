// SPDX-License-Identifier: MIT
// nlo sweep: writes many trainings of a plan as jobs for any job runner. nlo sweep collect: shows their results.
#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <map>
#include <memory>

#include "trainer/app/commands/command.h"
#include "trainer/app/commands/experiment_argument.h"
#include "trainer/app/commands/options.h"
#include "trainer/app/commands/output_directory.h"
#include "trainer/app/commands/patient_progress.h"
#include "trainer/app/commands/sweep_collect.h"
#include "trainer/app/commands/train_command.h"
#include "trainer/app/jobs/run_jobs.h"
#include "trainer/app/sweep/sweep_jobs.h"
#include "trainer/base/nearest_name.h"
#include "trainer/base/printable.h"

namespace nlo::trainer {
namespace {

namespace fs = std::filesystem;

struct SweepArguments {
  std::vector<std::string> words;  ///< [collect] PLAN
  std::string output;
  std::optional<std::string> shard;
  std::optional<int> threads;
  bool run = false, timed = false;
};

/// Returns a path of the plan relative to the current directory.
std::string beside(const std::string& plan, const std::string& path) {
  if (path.empty()) return path;
  const std::string found = (fs::path(plan).parent_path() / path).lexically_normal().string();
  return found.starts_with('-') ? "./" + found : found;
}

SweepPlaces places_of(const SweepPlan& plan, const SweepArguments& arguments) {
  std::error_code ignored;
  const std::string file = beside(plan.place, plan.experiment);
  SweepPlaces places;
  places.experiment =
      fs::exists(file, ignored) ? file : plan.experiment;  // otherwise a shipped experiment, or an error
  places.data = beside(plan.place, plan.data);
  places.folder = arguments.output.empty() ? "runs/" + fs::path(plan.place).stem().string() : arguments.output;
  places.threads = arguments.threads;
  return places;
}

ExperimentArgument argument_of(const SweepJob& job, const SweepPlaces& places) {
  return {places.experiment, job.assignments(), job.seed, places.threads};
}

/// Throws an error about a value of the plan, with its line.
[[noreturn]] void fail(const SweepPlan& plan, const SweepJob& job, const std::string& what) {
  for (const SweepValue& value : job.values) {
    const std::string set = fmt::format("--set {}={}", value.key, value.value);
    if (what.starts_with(set + ": ")) throw codegen::Error(value.place + what.substr(set.size()));
  }
  throw codegen::Error(job.values.empty() ? what : fmt::format("{}: job {}: {}", plan.place, job.name, what));
}

/// Returns all jobs, each with its experiment read and checked.
std::vector<CheckedJob> checked_jobs(const SweepPlan& plan, const SweepPlaces& places) {
  std::vector<CheckedJob> checked;
  std::map<std::string, std::string> seen;  // experiment -> job
  for (SweepJob& job : jobs_of(plan)) {
    try {
      Experiment experiment = read_draft(argument_of(job, places)).experiment;
      if (experiment.plant && !places.data.empty())
        throw codegen::Error(
            "data is only for experiments with a [log], but this one simulates its [plant]; leave data out");
      checked.push_back({std::move(job), std::move(experiment)});
    } catch (const codegen::Error& error) {
      fail(plan, job, error.what());
    }
    const CheckedJob& last = checked.back();
    const auto [before, is_new] = seen.emplace(last.experiment.source_text, last.job.name);
    if (!is_new)
      throw codegen::Error(fmt::format("{}: the plan has the same training twice, as {} and as {}; remove one",
                                       plan.place, before->second, last.job.name));
  }
  return checked;
}

/// Runs jobs one after another. A job that fails does not stop the others.
void run_here(const std::vector<CheckedJob>& jobs, const SweepPlaces& places, const Shard& shard,
              const std::string& command) {
  const std::atomic<bool>& stop = stop_on_interrupt();
  std::vector<Job> trainings;
  std::size_t refused = 0;  // number of jobs with wrong input
  for (std::size_t j = 0; j < jobs.size(); ++j)
    if (const SweepJob& job = jobs[j].job; shard.has(j))
      trainings.push_back({job.name, 1.0, [&](const JobContext&) {
                             fmt::print(stderr, "{}\n", job_line(job, places));
                             try {
                               run_train({.experiment = argument_of(job, places),
                                          .data = places.data,
                                          .output = places.folder + "/" + job.name,
                                          .resume = true,
                                          .quiet = true});
                             } catch (const codegen::Error& error) {
                               if (!stop.load()) fmt::print(stderr, "nlo: error: {}\n", printable(error.what()));
                               refused += dynamic_cast<const RunFailure*>(&error) == nullptr;
                               throw;
                             }
                             return JobEnd::kDone;
                           }});
  const JobsResult result = run_jobs(trainings, {.side_by_side = false, .keep_going = true, .stop = &stop});
  if (result.left > 0) throw RunFailure(result.interrupted_text(command));
  const std::size_t failed = result.failures.size();
  const std::string what = fmt::format("{} of {} jobs failed", failed, trainings.size());
  if (refused > 0 && refused == failed) throw codegen::InputError(what + ", all because of wrong input");
  if (failed > 0) throw RunFailure(what);
}

void run_sweep(const SweepArguments& arguments) {
  const bool collect = arguments.words.size() == 2;
  if (collect && arguments.words.front() != "collect")
    throw codegen::Error(fmt::format("{}: unknown action; write nlo sweep PLAN.toml, or nlo sweep collect PLAN.toml",
                                     arguments.words.front()));
  if (collect && (arguments.run || arguments.shard))
    throw codegen::Error("--shard and --run are only for running jobs; leave them out of nlo sweep collect");
  if (!collect && arguments.timed)
    throw codegen::Error("--time is only for nlo sweep collect, which evaluates the jobs; leave it out");
  if (is_stdout(arguments.output))
    throw codegen::Error("-o -: every job has its own folder, and stdout is not a folder; write -o DIR");
  const SweepPlan plan = read_sweep_plan(arguments.words.back());
  const Shard shard = arguments.shard ? parse_shard(*arguments.shard) : Shard{};
  const SweepPlaces places = places_of(plan, arguments);
  if (collect || arguments.run) check_output_directory(places.folder);
  const std::vector<CheckedJob> jobs = checked_jobs(plan, places);
  if (collect) {
    PatientProgress progress;
    run_phase([&] {
      const std::vector<JobResult> results =
          collect_results(jobs, plan.test, places, arguments.timed,
                          [&](double share, const std::string& job) { progress.update(share, job); });
      progress.finish();
      fmt::print("{}", printable(write_collection(jobs, results, places.folder)));
    });
  } else if (arguments.run) {
    std::string command = "nlo sweep " + shell_word(plan.place) + " --run";
    if (arguments.shard) command += " --shard " + *arguments.shard;
    if (arguments.threads) command += fmt::format(" --threads {}", *arguments.threads);
    run_here(jobs, places, shard, command + " -o " + shell_word(places.folder));
  } else {
    std::string lines;
    for (std::size_t j = 0; j < jobs.size(); ++j)
      if (shard.has(j)) lines += job_line(jobs[j].job, places) + "\n";
    fmt::print("{}", lines);
  }
}

}  // namespace

void add_sweep(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<SweepArguments>();
  CLI::App* command =
      app.add_subcommand("sweep", "Write many trainings of a plan as jobs, one line each; then collect their results");
  Options options(*command);
  options
      .value("PLAN", arguments->words,
             "plan: experiment, seeds, [grid], [[zip]], [[point]]; after \"collect\": shows the results of its jobs",
             "[collect] PLAN.toml")
      ->required()
      ->expected(1, 2);
  options.directory("-o,--output", arguments->output,
                    "directory for the folders of the jobs and sweep.csv (default: runs/PLAN)");
  options.value("--shard", arguments->shard, "only part I of N: every N-th job, I from 0 to N - 1", "I/N");
  options.flag("--run", arguments->run, "run the jobs here, one after another, instead of writing them");
  options
      .value("--threads", arguments->threads, "number of threads of each job; 0: all cores; does not affect the result")
      ->check(CLI::Range(0, 1024));
  options.flag("--time", arguments->timed,
               "collect: also measure the time of a step and an estimate on this machine [ns]");
  command->footer(
      "A finished job does nothing if it is run again. A killed job continues, and its result has the same bytes.\n"
      "collect writes sweep.csv, a row for each job, and pareto.svg: error against multiply-adds, flash and, with "
      "--time, ns.\n"
      "Examples:\n"
      "  nlo sweep plan.toml --threads 1 | parallel\n"
      "  nlo sweep plan.toml --run --shard \"$SLURM_ARRAY_TASK_ID/16\"\n"
      "  nlo sweep collect plan.toml");
  command->callback([arguments, &action] { action = [arguments] { run_sweep(*arguments); }; });
}

}  // namespace nlo::trainer

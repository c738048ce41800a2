// SPDX-License-Identifier: MIT
#include "trainer/app/commands/sweep_collect.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <limits>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "codegen/model_file/model_file.h"
#include "trainer/app/commands/model_cost.h"
#include "trainer/app/commands/output_directory.h"
#include "trainer/app/commands/run_report.h"
#include "trainer/app/jobs/finished_run.h"
#include "trainer/app/report/pareto_figure.h"
#include "trainer/app/report/svg_text.h"
#include "trainer/base/number_text.h"
#include "trainer/data/log_dataset.h"
#include "trainer/experiments/mirrored_channels.h"
#include "trainer/judge/evaluation/evaluate.h"

namespace nlo::trainer {
namespace {

JobStatus status_of(const std::string& folder, const Experiment& experiment, std::string& failure) {
  if (const auto run = read_finished_run(folder)) {
    if (run->experiment != run_identity(experiment)) return JobStatus::kOther;
    failure = run->failure;
    return failure.empty() ? JobStatus::kDone : JobStatus::kFailed;
  }
  std::error_code ignored;
  return std::filesystem::exists(folder, ignored) ? JobStatus::kUnfinished : JobStatus::kMissing;
}

double test_error(const codegen::Model& model, const Experiment& experiment, const SweepTest& test,
                  const SweepPlaces& places) {
  if (experiment.log) {
    const LogSplits splits = load_log_splits(*experiment.log, places.data, mirrored_channels(experiment));
    const RunReport report = report_on_logs(model, experiment, splits.train, logs_to_report_on(splits), splits.report);
    return report.logs->metrics.norm;
  }
  StudyTest strict;
  strict.conditions = conditions_of({test.noise.value_or(experiment.training.all_noise().parts.front())},
                                    {.input_noise = experiment.training.input_noise});
  strict.seed = test.seed;
  strict.trajectories = test.trajectories;
  strict.threads = places.threads.value_or(0);
  return report_on_plant(model, experiment, strict).rows.front().observer().first().metrics.norm;
}

/// Returns the time of a sample [ns] with the observer of nlo evaluate, over outputs across its range.
double measured_ns(const codegen::Model& model) {
  using Clock = std::chrono::steady_clock;
  constexpr Eigen::Index kSamples = 2000;
  constexpr int kRuns = 10;
  const Eigen::VectorXd time =
      Eigen::VectorXd::LinSpaced(kSamples, 0.0, static_cast<double>(kSamples - 1)) * model.sample_period_s;
  Eigen::MatrixXd y(model.ny(), kSamples);
  for (Eigen::Index j = 0; j < y.rows(); ++j)
    y.row(j).array() = 0.5 * (model.output_min(j) + model.output_max(j)) +
                       0.4 * (model.output_max(j) - model.output_min(j)) *
                           Eigen::ArrayXd::LinSpaced(kSamples, 0.0, 60.0).sin().transpose();
  const Eigen::MatrixXd u = Eigen::MatrixXd::Zero(model.nu(), model.nu() > 0 ? kSamples : 0);
  const ObserverRun observer = observer_run(model, true);
  double least = std::numeric_limits<double>::infinity();
  for (int run = 0; run < kRuns; ++run) {
    const auto start = Clock::now();
    (void)observer(y, u, time);
    least = std::min(least, std::chrono::duration<double, std::nano>(Clock::now() - start).count());
  }
  return least / static_cast<double>(kSamples);
}

std::optional<double> fact(const codegen::Model& model, const std::string& name) {
  for (const auto& [key, value] : model.provenance)
    if (key == name) return finite_number(value);
  return std::nullopt;
}

}  // namespace

std::vector<JobResult> collect_results(const std::vector<CheckedJob>& jobs, const SweepTest& test,
                                       const SweepPlaces& places, bool timed,
                                       const std::function<void(double share, const std::string& job)>& progress) {
  std::vector<JobResult> results;
  for (const CheckedJob& checked : jobs) {
    progress(static_cast<double>(results.size()) / static_cast<double>(jobs.size()), checked.job.name);
    JobResult& result = results.emplace_back();
    const std::string folder = places.folder + "/" + checked.job.name;
    result.status = status_of(folder, checked.experiment, result.message);
    if (result.status != JobStatus::kDone) continue;
    const codegen::Model model = codegen::read_model(folder + "/model.json");
    result.validation_error = fact(model, "validation_rmse");
    result.error = test_error(model, checked.experiment, test, places);
    result.cost = model_cost(model);
    if (timed) result.cost->ns = measured_ns(model);
  }
  return results;
}

std::string write_collection(const std::vector<CheckedJob>& checked, const std::vector<JobResult>& results,
                             const std::string& folder) {
  std::vector<SweepJob> jobs;
  for (const CheckedJob& each : checked) jobs.push_back(each.job);
  const std::vector<PointResult> points = point_results(jobs, results);
  make_output_directory(folder);
  codegen::write_file_atomically(folder + "/sweep.csv", sweep_csv(jobs, results));
  std::string written = fmt::format("\ntable    {}/sweep.csv\n", folder);
  if (const Figure figure = pareto_figure(points); !figure.panels.empty()) {
    const Drawing drawing = draw({figure});
    if (!drawing.failure.empty())
      throw codegen::Error(
          fmt::format("{0}/pareto.svg: {1}. Install gnuplot (Debian: gnuplot-nox); the table is in {0}/sweep.csv",
                      folder, drawing.failure));
    codegen::write_file_atomically(folder + "/pareto.svg", standalone_svg(drawing.svgs.front()));
    written += fmt::format("picture  {}/pareto.svg\n", folder);
  }
  return sweep_text(jobs, results, points) + written;
}

}  // namespace nlo::trainer

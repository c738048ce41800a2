// SPDX-License-Identifier: MIT
#include "trainer/identify/filter_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "trainer/data/evaluation_windows.h"
#include "trainer/data/log_baselines.h"
#include "trainer/data/log_files.h"
#include "trainer/identify/identified_filter.h"
#include "trainer/judge/evaluation/text.h"
#include "trainer/judge/filters/constant_acceleration.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Returns estimates of every run by every point, points x runs, computed by all threads.
template <class Estimate>
std::vector<std::vector<MatrixXd>> estimates_of(std::size_t points, const Dataset& logs, ThreadPool& pool,
                                                const Estimate& estimate) {
  const std::size_t runs = logs.trajectories.size();
  std::vector<std::vector<MatrixXd>> all(points, std::vector<MatrixXd>(runs));
  pool.run(static_cast<int>(points * runs), [&](int task, int) {
    const auto point = static_cast<std::size_t>(task) / runs, run = static_cast<std::size_t>(task) % runs;
    all[point][run] = estimate(point, logs.trajectories[run]);
  });
  return all;
}

/// Returns the RMSE of each logged state over all samples.
std::vector<double> rmse_of(const Dataset& logs, const std::vector<MatrixXd>& estimates) {
  std::vector<double> rmse;
  for (const StateError& state : log_metrics(logs, estimates).pooled) rmse.push_back(state.rmse.front());
  return rmse;
}

std::vector<double> constant_rmse(const Dataset& logs) {
  const VectorXd mean = mean_states(logs);
  std::vector<MatrixXd> estimates;
  for (const Trajectory& run : logs.trajectories) estimates.emplace_back(mean.replicate(1, run.samples()));
  return rmse_of(logs, estimates);
}

/// The logs for tuning and for the test, each started at every time of from_s.
struct Logs {
  Dataset training, tuning, judged;
};

class Study {
 public:
  Study(const Identification& identification, Logs logs, const LogSchema& schema, ThreadPool& pool,
        const std::atomic<bool>* stop, const StudyProgress& progress)
      : identification_(identification),
        logs_(std::move(logs)),
        schema_(schema),
        pool_(pool),
        stop_(stop),
        progress_(progress),
        scale_(constant_rmse(logs_.tuning)) {
    windows_ = identification.evaluation.windows.empty()
                   ? whole_run()
                   : evaluation_windows(identification.evaluation, 0.0, logs_.judged.longest_s());
  }

  void filters(const VectorXd& p) {
    const IdentifiedFilter filter(identification_, p, logs_.tuning);
    VectorXd tuning = filter.tuning();
    const double period_s = logs_.judged.sample_period_s;
    for (const PointSet kind : {PointSet::kExtended, PointSet::kUnscented}) {
      const bool extended = kind == PointSet::kExtended;
      const std::string name = extended ? "ekf" : "ukf";
      const CostsOf costs = [&](const std::vector<VectorXd>& points) {
        const auto estimates = estimates_of(
            points.size(), logs_.tuning, pool_,
            [&](std::size_t i, const Trajectory& run) { return filter.estimate_from_nearest(kind, points[i], run); });
        std::vector<double> result;
        for (const auto& each : estimates) result.push_back(relative(rmse_of(logs_.tuning, each)));
        evaluations_ += static_cast<int>(points.size());
        // About two sweeps for each step size, in both directions. The EKF fills the first half of the progress bar.
        const double sweeps = extended ? 6.0 : 4.0, expected = sweeps * 2.0 * static_cast<double>(tuning.size());
        say(0.45 * (extended ? 0.0 : 1.0) + 0.45 * std::min(1.0, evaluations_ / expected),
            fmt::format("tuning the {}: {} tried", name, evaluations_));
        return result;
      };
      evaluations_ = 0;
      const Tuned tuned = coordinate_search(tuning, costs, !extended, stop_);
      tuning = tuned.x;
      judge(name, filter.describe(tuning), filter.step_cost(kind, period_s),
            [&](const Trajectory& run) { return filter.estimate(kind, tuning, run); });
    }
  }

  void constant_acceleration() {
    std::vector<ConstantAcceleration> filters(schema_.state_sources.size());
    std::vector<std::string> describe(filters.size());
    std::string setup;
    double count = 0.0;
    for (std::size_t i = 0; i < filters.size(); ++i) {
      if (!applies(i)) continue;
      const StateSource& source = schema_.state_sources[i];
      const auto costs = [&](const std::vector<VectorXd>& points) {
        const auto estimates =
            estimates_of(points.size(), logs_.tuning, pool_, [&](std::size_t k, const Trajectory& run) {
              MatrixXd x = MatrixXd::Constant(run.states.rows(), run.samples(), kNone);
              x.row(static_cast<Index>(i)) =
                  with(points[k][0], source).estimate(run.time_s, measured(i, run)).row(row(i));
              return x;
            });
        std::vector<double> result;
        for (const auto& each : estimates) result.push_back(rmse_of(logs_.tuning, each)[i]);
        return result;
      };
      // The search starts at a filter whose time constant is three samples: (r / q)^(1/5) = 3 h.
      const double start = -5.0 * std::log10(3.0 * logs_.tuning.sample_period_s);
      const double log_q = coordinate_search(VectorXd::Constant(1, start), costs, false, stop_, 12).x[0];
      filters[i] = with(log_q, source);
      setup += fmt::format("{}(q/r)^(1/5) of {}: {} 1/s", setup.empty() ? "" : ", ", logs_.judged.states[i].name,
                           significant(std::pow(10.0, log_q / 5.0), 2));
      describe[i] = "constant_acceleration";
      count += 1.0;
    }
    if (count == 0.0) return;
    judge("constant_acceleration", setup, cost_of_constant_acceleration() * count, [&](const Trajectory& run) {
      MatrixXd x = MatrixXd::Constant(run.states.rows(), run.samples(), kNone);
      for (std::size_t i = 0; i < filters.size(); ++i)
        if (applies(i)) x.row(static_cast<Index>(i)) = filters[i].estimate(run.time_s, measured(i, run)).row(row(i));
      return x;
    });
    study.entries.back().describe = describe;
  }

  void without_a_plant() {
    judge_baselines(study.entries, logs_.training, logs_.judged, schema_, {}, windows_, [&](const std::string& name) {
      say(0.95, name);
      return true;
    });
  }

  FilterStudy study;

 private:
  template <class Estimate>
  void judge(const std::string& name, const std::string& setup, const StepCost& cost, const Estimate& estimate) {
    const auto estimates = estimates_of(1, logs_.judged, pool_,
                                        [&](std::size_t, const Trajectory& run) { return MatrixXd(estimate(run)); });
    study.entries.push_back({name, {}, log_metrics(logs_.judged, estimates.front(), {}, windows_), cost, setup});
  }

  double relative(const std::vector<double>& rmse) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < rmse.size(); ++i) sum += rmse[i] / scale_[i];
    return sum;
  }

  bool applies(std::size_t i) const {
    const StateKind kind = schema_.state_sources[i].kind;
    return (kind == StateKind::kMeasured || kind == StateKind::kDerivativeOfMeasured) &&
           schema_.state_sources[i].cosine < 0;
  }

  /// Returns the row of the logged state among the filter's three states.
  Index row(std::size_t i) const { return schema_.state_sources[i].kind == StateKind::kMeasured ? 0 : 1; }

  VectorXd measured(std::size_t i, const Trajectory& run) const {
    return run.outputs.row(schema_.state_sources[i].output);
  }

  static ConstantAcceleration with(double log_q, const StateSource& source) {
    return {std::pow(10.0, log_q), 1.0, source.wrap};
  }

  void say(double share, const std::string& what) const {
    if (progress_) progress_(share, what);
  }

  const Identification& identification_;
  Logs logs_;
  const LogSchema& schema_;
  ThreadPool& pool_;
  const std::atomic<bool>* stop_;
  const StudyProgress& progress_;
  std::vector<double> scale_;
  EvaluationWindows windows_;
  int evaluations_ = 0;
};

}  // namespace

FilterStudy study_filters(const Identification& identification, const VectorXd& p, const LogSplits& splits,
                          const LogSchema& schema, ThreadPool& pool, const std::atomic<bool>* stop,
                          const StudyProgress& progress) {
  const auto& from_s = identification.identify.from_s;
  const bool validation = !splits.validation.trajectories.empty(), test = !splits.test.trajectories.empty();
  const Dataset& tuning = validation ? splits.validation : splits.train;
  Study study(identification,
              {splits.train, started_at(tuning, from_s), started_at(test ? splits.test : tuning, from_s)}, schema, pool,
              stop, progress);
  study.study.tuned_on = validation ? "the validation logs" : "the training logs";
  study.study.judged_on = test ? "the test logs" : study.study.tuned_on;
  study.study.sample_period_s = splits.train.sample_period_s;
  study.filters(p);
  study.constant_acceleration();
  study.without_a_plant();
  return study.study;
}

}  // namespace nlo::trainer

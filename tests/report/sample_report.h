// SPDX-License-Identifier: MIT
// A report with all sections, from made-up but plausible data, which the tests render.
#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "tests/compare/plants.h"
#include "tests/evaluation/van_der_pol_set.h"
#include "tests/support/row_of.h"
#include "trainer/app/report/report.h"
#include "trainer/judge/compare/table_filter.h"
#include "trainer/judge/evaluation/examples.h"

namespace nlo::trainer::test {

/// Returns the truth plus a decaying and a lasting error, like an observer, but without training one.
inline EstimatorFactory pretended_observer(double lasting) {
  return [lasting]() -> Estimator {
    return [lasting](const Eigen::MatrixXd& outputs, const Eigen::MatrixXd&, const Eigen::VectorXd& time_s) {
      Eigen::MatrixXd estimate(2, outputs.cols());
      for (Eigen::Index k = 0; k < outputs.cols(); ++k) {
        const double fading = std::exp(-1.2 * time_s[k]);
        const Eigen::Index from = std::max<Eigen::Index>(0, k - 20);
        const double noise = outputs.row(0).segment(from, k - from + 1).mean();
        estimate(0, k) = (1.0 - fading) * noise + lasting * std::sin(3.0 * time_s[k]);
        estimate(1, k) = (1.0 - fading) * 1.5 * std::sin(0.94 * time_s[k]) + lasting;
      }
      return estimate;
    };
  };
}

inline TrainingCurves sample_curves() {
  std::string csv =
      "step,elapsed_s,loss,train_rmse,validation_rmse,learning_rate,lambda_1_re,lambda_1_im,lambda_2_re,lambda_2_im\n";
  for (int i = 0; i <= 1000; i += 20) {
    const double t = i / 1000.0, loss = 0.02 + 2.0 * std::exp(-8.0 * t) + 0.004 * std::sin(0.9 * i);
    csv += std::to_string(i) + "," + std::to_string(10.0 * t) + "," + std::to_string(loss) + "," +
           std::to_string(std::sqrt(loss)) + "," + std::to_string(1.03 * std::sqrt(loss)) + ",0.003," +
           std::to_string(-0.5 + 0.2 * t) + "," + std::to_string(1.1 - 0.2 * t) + "," + std::to_string(-3.0 - 2.0 * t) +
           ",0\n";
  }
  return parse_training_curves(csv, "metrics.csv");
}

inline ControlLoopResult sample_loop() {
  ControlLoopResult loop;
  loop.rate_hz = 1000;
  loop.ticks = 10'000;
  loop.noise_std = 0.5;
  loop.rms_error = 0.172;
  loop.settled_rms_error = 0.081;
  loop.step_and_estimate = {231, 412, 1500, 23'400};
  loop.wake_up_lateness = {52'000, 91'000, 130'000, 900'000};
  for (double below = 190.0, count = 40.0; below < 30'000.0; below *= 1.25) {
    loop.histogram.push_back({below, count});
    count = below < 240.0 ? 6000.0 : std::floor(count / 3.1);
    if (count < 1.0) count = below > 20'000.0 ? 1.0 : 0.0;
  }
  return loop;
}

/// Logs of a pendulum that makes full turns and whose angle is measured. The estimates of angle and rate have a large
/// initial error and a lasting error that grows from log to log. The last tenth of each log is masked, and z starts
/// outside of its domain.
inline LogEvaluation sample_logs(int count) {
  constexpr Eigen::Index kSamples = 1500;
  constexpr double kTurn = 2.0 * std::numbers::pi;
  Dataset logs{{{"angle", "rad", kTurn}}, {{"angle", "rad", kTurn}, {"rate", "rad/s", 0.0}}, 0.01, true, {}};
  std::vector<Eigen::MatrixXd> estimates;
  std::vector<double> errors;
  for (int i = 0; i < count; ++i) {
    const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(kSamples, 0.0, 0.01 * (kSamples - 1));
    const Eigen::ArrayXd phase = 1.7 * t.array() + i;
    Eigen::MatrixXd x(2, kSamples), x_hat;
    x.row(0) = (0.8 * t.array() + 1.5 * phase.sin()).matrix().transpose();
    x.row(1) = (0.8 + 1.5 * 1.7 * phase.cos()).matrix().transpose();
    x_hat = x;
    x_hat.row(0).array() += kTurn + 0.02 * (i + 1) * (5.0 * t.array().transpose()).sin();
    x_hat.row(1).array() += 200.0 * (-12.0 * t.array().transpose()).exp() + 0.05 * (9.0 * t.array().transpose()).sin();
    Eigen::VectorXd weight = Eigen::VectorXd::Ones(kSamples);
    weight.tail(kSamples / 10).setZero();
    logs.trajectories.push_back({"run_" + std::to_string(i + 1) + ".csv", t, x.row(0), x, weight});
    estimates.push_back(x_hat);
    errors.push_back(relative_error(logs.trajectories.back(), x_hat, logs.states, Eigen::Vector2d(1.0, 2.0)));
  }
  LogEvaluation evaluation;
  evaluation.entries.push_back({"observer", {}, log_metrics(logs, estimates)});
  evaluation.states = logs.states;
  evaluation.outputs = logs.outputs;
  evaluation.split = "test";
  evaluation.baselines_fitted_on = "the training logs";
  for (const Chosen& chosen : spread_choice(errors)) {
    const Trajectory& log = logs.trajectories[chosen.run];
    evaluation.examples.push_back({log, log.outputs, estimates[chosen.run], chosen.why});
    evaluation.examples.back().outside = (log.time_s.array() < 0.3).cast<double>();
  }
  return evaluation;
}

inline ReportData sample_report(int trajectories = 40) {
  ReportData data;
  data.title = "van_der_pol";
  data.facts = {{"nlo", "0.1.0"},
                {"seed", "1"},
                {"data", "50 simulated trajectories of 50 s"},
                {"config", "name = \"van_der_pol\"\n[training]\nsteps = 1000"}};
  data.training = sample_curves();
  const Dataset set = van_der_pol_set(trajectories, 50.0, 4);
  for (const NoiseConfig& noise : {NoiseConfig{}, {NoiseKind::kGaussian, 0.5}, {NoiseKind::kUniform, 3.0}}) {
    data.rows.push_back(
        row_of("van_der_pol", {evaluate("observer", pretended_observer(0.05), set, noise, 1, 1),
                               evaluate("ekf", table_filter("ekf", van_der_pol(), noise, false), set, noise, 1, 1),
                               evaluate("constant", baseline_estimator("constant", set), set, noise, 1, 1)}));
  }
  data.control_loop = sample_loop();
  return data;
}

}  // namespace nlo::trainer::test

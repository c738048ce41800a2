// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/evaluate_logs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "codegen/replay/reference_observer.h"
#include "tests/support/thrown_message.h"
#include "trainer/judge/evaluation/evaluation_text.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;

constexpr double kStep = 0.01, kRate = 2.0;  // q = sin(2 t)

/// Two logs of a swing: the angle q is measured; its velocity dq and an unrelated state `hidden` are estimated.
Dataset swing_logs() {
  Dataset logs{{{"q", "rad", 0.0}}, {{"dq", "rad/s", 0.0}, {"hidden", "m", 0.0}}, kStep, true, {}};
  for (const double phase : {0.0, 1.0}) {
    const Eigen::VectorXd t = kStep * Eigen::VectorXd::LinSpaced(1201, 0.0, 1200.0);
    const Eigen::ArrayXd angle = kRate * t.array() + phase;
    Eigen::MatrixXd states(2, t.size());
    states.row(0) = (kRate * angle.cos()).matrix().transpose();
    states.row(1) = (7.3 * t.array() + phase).sin().matrix().transpose();
    logs.trajectories.push_back({phase == 0.0 ? "first.csv" : "second.csv", t, angle.sin().matrix().transpose(), states,
                                 Eigen::VectorXd::Ones(t.size())});
  }
  return logs;
}

LogSchema swing_schema() {
  LogSchema schema;
  schema.state_sources = {{StateKind::kDerivativeOfMeasured, 0, -1, 0.0}, {}};
  return schema;
}

/// z follows q at 50 1/s; dq is estimated by 50 (q - z), a filtered derivative, and `hidden` by the constant `guess`.
codegen::Model differentiator(double guess) {
  constexpr double kPole = 50.0;
  codegen::Model model;
  model.name = "differentiator";
  model.outputs = {{"q", "rad", 0.0}};
  model.states = {{"dq", "rad/s", 0.0}, {"hidden", "m", 0.0}};
  model.sample_period_s = kStep;
  codegen::linear_latent(model)->eigenvalues = Eigen::VectorXd::Constant(1, -kPole);
  codegen::linear_latent(model)->output_injection = Eigen::MatrixXd::Constant(1, 1, kPole);
  model.initial_latent = Eigen::VectorXd::Zero(1);
  codegen::linear_latent(model)->starts_steady = true;
  model.output_min = model.latent_min = Eigen::VectorXd::Constant(1, -100.0);
  model.output_max = model.latent_max = Eigen::VectorXd::Constant(1, 100.0);
  codegen::inverse_map(model)->features = Eigen::RowVector2d(-1.0, 1.0);
  codegen::inverse_map(model)->feature_mean = Eigen::VectorXd::Zero(1);
  codegen::inverse_map(model)->feature_scale = Eigen::VectorXd::Ones(1);
  codegen::inverse_map(model)->layers = {{Eigen::Vector2d(kPole, 0.0), Eigen::Vector2d(0.0, guess)}};
  codegen::inverse_map(model)->output_mean = Eigen::VectorXd::Zero(2);
  codegen::inverse_map(model)->output_scale = Eigen::VectorXd::Ones(2);
  return model;
}

MetricsConfig after_2_s() {
  MetricsConfig config;
  config.windows.push_back({"after_2_s", 2.0, std::numeric_limits<double>::infinity()});
  return config;
}

LogEvaluation evaluated(const NoiseConfig& noise = {}, double guess = 1.0, const Dataset& logs = swing_logs()) {
  return evaluate_on_logs(differentiator(guess), logs, swing_schema(), nullptr, noise, 1, after_2_s());
}

TEST(EvaluateLogs, FilteredDerivativeHasTheErrorOfItsFrequencyResponse) {
  // Amplitude error |1 - p / (p + i w)| = w / sqrt(p^2 + w^2) for a velocity with RMS w / sqrt(2).
  const double expected = kRate / std::hypot(50.0, kRate) * kRate / std::sqrt(2.0);
  constexpr double kPartialPeriod = 0.05;  // 10 s contain 3.2 periods, not a whole number
  const LogEvaluation result = evaluated();
  EXPECT_NEAR(result.entries[0].metrics.pooled[0].rmse[1], expected, kPartialPeriod * expected);
}

TEST(EvaluateLogs, ShowsBaselinesAndDifferencesOnlyOfMeasuredStates) {
  const LogEvaluation result = evaluated();
  ASSERT_GE(result.entries.size(), 3U);
  EXPECT_EQ(result.entries[0].estimator, "observer");
  EXPECT_EQ(result.entries[1].estimator, "constant");
  EXPECT_TRUE(std::isfinite(result.entries[1].metrics.pooled[1].rmse[0]));
  EXPECT_TRUE(std::isfinite(result.entries[2].metrics.pooled[0].rmse[0]));
  EXPECT_FALSE(std::isfinite(result.entries[2].metrics.pooled[1].rmse[0]));  // no measurement to difference
}

TEST(SensorFault, IsMissingStuckOrDeadFromTheGivenTimeOn) {
  const Dataset logs = swing_logs();
  const auto q = [&](const std::string& word) -> Eigen::VectorXd {
    return with_faults(logs, {parse_fault(word)}).trajectories.front().outputs.row(0);
  };
  const Eigen::VectorXd clean = logs.trajectories.front().outputs.row(0);
  constexpr Eigen::Index kSound = 500;  // samples before 5 s
  for (const char* word : {"q:missing:5", "q:stuck:5", "q:dead:5"}) EXPECT_EQ(q(word).head(kSound), clean.head(kSound));
  EXPECT_TRUE(q("q:missing:5").tail(701).array().isNaN().all());
  EXPECT_TRUE((q("q:stuck:5").tail(701).array() == clean[kSound - 1]).all());
  EXPECT_TRUE((q("q:dead:5").tail(701).array() == 0.0).all());
  EXPECT_TRUE(q("q").array().isNaN().all());
  EXPECT_TRUE((q("q:stuck").array() == clean[0]).all());
  for (const char* word : {"", ":stuck", "q:wrong", "q:stuck:", "q:stuck:soon", "q:stuck:-1", "q:stuck:1:2"})
    EXPECT_THAT(thrown_message([&] { (void)parse_fault(word); }), HasSubstr("is not OUTPUT, OUTPUT:stuck or")) << word;
  EXPECT_THAT(thrown_message([&] { (void)q("r:dead"); }), HasSubstr("there is no such output; there are q"));
}

TEST(EvaluateLogs, EstimatorsAreNotToldWhichSensorIsFaulty) {
  const auto flown = [](std::vector<SensorFault> faults) {
    return evaluate_on_logs(differentiator(1.0), swing_logs(), swing_schema(), nullptr, {}, 1, after_2_s(), {},
                            {faults});
  };
  const LogEvaluation stuck = flown({parse_fault("q:stuck:5")}), missing = flown({parse_fault("q:missing:5")});
  EXPECT_GT(stuck.entries.size(), missing.entries.size()) << "alternatives also read the faulty sensor";
  EXPECT_GT(stuck.entries[0].metrics.pooled[0].rmse[0], 2.0 * evaluated().entries[0].metrics.pooled[0].rmse[0]);
  EXPECT_THAT(evaluation_text("differentiator", stuck), HasSubstr("without q:stuck from 5.00 s on, noise"));
}

TEST(EvaluateLogs, NotesAStateThatTheOutputsDoNotDetermine) {
  const LogEvaluation result = evaluated();
  ASSERT_EQ(result.notes.size(), 2U);                                     // control: dq is estimated
  EXPECT_THAT(result.notes[0], HasSubstr("dq does not need a network"));  // its map is linear in its features
  EXPECT_THAT(result.notes[1], HasSubstr("hidden is not observed"));
  EXPECT_THAT(evaluation_text("differentiator", result), HasSubstr("not clearly below that of a constant"));
}

TEST(EvaluateLogs, ComparesAnAngleGivenByTwoStates) {
  LogSchema schema = swing_schema();
  schema.angle_pairs = {{"turn", "rad", 6.283185307179586, 0}};  // dq and hidden; any two states would do
  const LogEvaluation result = evaluate_on_logs(differentiator(1.0), swing_logs(), schema, nullptr, {}, 1, after_2_s());
  ASSERT_EQ(result.entries[0].metrics.pooled.size(), 3U);
  for (const LogEntry& entry : result.entries)
    EXPECT_LE(entry.describe.size(), 2U) << "control: " << entry.estimator << " does not describe the angle";
  EXPECT_THAT(result.notes, ::testing::Contains(HasSubstr("turn ")));
}

TEST(EvaluateLogs, AddedNoiseIncreasesTheErrorAndDependsOnItsSeed) {
  const NoiseConfig noise{NoiseKind::kGaussian, 0.02};
  EXPECT_GT(evaluated(noise).entries[0].metrics.pooled[0].rmse[1],
            2.0 * evaluated().entries[0].metrics.pooled[0].rmse[1]);
  EXPECT_EQ(evaluated(noise).metrics.norm, evaluated(noise).metrics.norm);
}

TEST(EvaluateLogs, JsonNamesStatesUnitsAndFilesAndHoldsNoNonFiniteNumber) {
  const auto json = nlohmann::json::parse(evaluation_json("differentiator", evaluated()));
  EXPECT_EQ(json.at("norm_of"), "states over their standard deviation");  // rad/s and m cannot be added
  EXPECT_TRUE(json.at("norm").is_number());
  EXPECT_EQ(json.at("in_domain").at("share"), 1.0);
  EXPECT_EQ(json.at("unscored").at("share"), 0.0);
  EXPECT_EQ(json.at("per_component").size(), 2U);
  EXPECT_EQ(json.at("per_state").at(0).at("name"), "dq");
  EXPECT_EQ(json.at("per_state").at(0).at("unit"), "rad/s");
  EXPECT_TRUE(json.at("per_state").at(0).at("rmse").at("after_2_s").is_number());
  EXPECT_TRUE(json.at("per_state").at(1).at("against").at("difference").at("all").is_null());
  EXPECT_EQ(json.at("files").size(), 2U);
  EXPECT_EQ(json.at("noise"), "none");
}

TEST(EvaluateLogs, AStateWithoutATruthIsUnscoredAndDoesNotAffectOthers) {
  const LogEvaluation all = evaluated();
  Dataset logs = swing_logs();
  logs.states.pop_back();  // `hidden`
  for (Trajectory& run : logs.trajectories) run.states = run.states.topRows(1).eval();
  LogSchema schema = swing_schema();
  schema.state_sources.pop_back();
  const LogEvaluation some = evaluate_on_logs(differentiator(1.0), logs, schema, nullptr, {}, 1, after_2_s());
  EXPECT_THAT(all.unscored_states, testing::IsEmpty());
  EXPECT_THAT(some.unscored_states, testing::ElementsAre("hidden"));
  ASSERT_EQ(some.entries.size(), all.entries.size());
  for (std::size_t e = 0; e < all.entries.size(); ++e) {
    EXPECT_EQ(some.entries[e].estimator, all.entries[e].estimator);
    ASSERT_EQ(some.entries[e].metrics.pooled.size(), 1U);
    for (std::size_t w = 0; w < all.entries[e].metrics.windows.size(); ++w)
      EXPECT_NEAR(some.entries[e].metrics.pooled[0].rmse[w], all.entries[e].metrics.pooled[0].rmse[w], 1e-12);
  }
  EXPECT_EQ(some.examples[0].all_estimates.rows(), 2) << "it is estimated although it has no truth";
  EXPECT_THAT(evaluation_text("m", some), HasSubstr("unscored: hidden, because these logs have no truth for them"));
  EXPECT_THAT(evaluation_text("m", all), testing::Not(HasSubstr("no truth")));
  EXPECT_EQ(nlohmann::json::parse(evaluation_json("m", some))["unscored"]["states"][0], "hidden");
}

TEST(EvaluateLogs, ReportsUnscoredSamplesAndChecksTheirEstimates) {
  Dataset logs = swing_logs();
  for (Trajectory& run : logs.trajectories) {
    run.weight.head(20).setZero();
    run.weight.tail(20).setZero();
  }
  const LogEvaluation sane = evaluated({}, 1.0, logs);
  EXPECT_NEAR(sane.unscored.share, 40.0 / 1201.0, 1e-12);
  EXPECT_EQ(sane.unscored.where, "the first 0.20 s and the last 0.20 s of each log");
  const std::string text = evaluation_text("differentiator", sane);
  EXPECT_THAT(text, HasSubstr("unscored: 3.33 % of the samples, the first 0.20 s"));
  EXPECT_THAT(text, HasSubstr("in domain: 100 % of the samples; 2 of 2 first samples of a log"));
  EXPECT_EQ(sane.notes.size(), 2U);  // control: no note about unscored samples

  logs.trajectories[1].outputs(0, 3) += 10.0;  // a jump of the sensor while nothing is scored: dq is wrong by 500 rad/s
  const LogEvaluation wild = evaluated({}, 1.0, logs);
  ASSERT_EQ(wild.notes.size(), 3U);
  EXPECT_THAT(wild.notes[2], HasSubstr("dq is estimated as"));
  EXPECT_THAT(wild.notes[2],
              HasSubstr("at t = 0.0300 s of second.csv, where the truth is unknown and nothing is scored"));
  EXPECT_THAT(wild.notes[2], HasSubstr("in scored samples it is between -2.00 and 2.00 rad/s"));
}

TEST(EvaluateLogs, CountsUnscoredSamplesInsideALog) {
  Dataset logs = swing_logs();
  logs.trajectories[0].weight.segment(100, 5).setZero();
  EXPECT_EQ(find_unscored(logs).where, "5 samples inside");
}

TEST(EvaluateLogs, AnEmptyCellIsAMissingMeasurement) {
  Dataset holey = swing_logs();
  for (Trajectory& run : holey.trajectories) {
    run.missing.setConstant(1, run.samples(), false);
    for (Eigen::Index k = 400; k < 450; ++k) {
      run.missing(0, k) = true;
      run.outputs(0, k) = run.outputs(0, 399);
    }
  }
  Dataset given = swing_logs();  // the same measurements as in flight
  for (Trajectory& run : given.trajectories) run.outputs.middleCols(400, 50).setConstant(std::nan(""));
  const LogEvaluation result = evaluated({}, 1.0, holey);
  for (std::size_t i = 0; i < 2; ++i) {
    const Trajectory& run = given.trajectories[i];
    const Eigen::MatrixXd flown =
        codegen::ReferenceObserver<float>(differentiator(1.0)).run(run.outputs, {}, run.time_s, true).x_hat;
    ASSERT_EQ(result.examples[i].estimate, flown);
  }
  EXPECT_GT(result.entries[0].metrics.pooled[0].rmse[0], 1.5 * evaluated().entries[0].metrics.pooled[0].rmse[0]);
  for (const auto& entry : result.entries) {  // baselines read the last value
    if (entry.estimator != "difference") continue;
    EXPECT_TRUE(std::isfinite(entry.metrics.pooled[0].rmse[0]));
  }
}

TEST(EvaluateLogs, RefusesOtherColumnsByName) {
  codegen::Model model = differentiator(0.0);
  model.states[1].name = "lost";
  EXPECT_THAT(thrown_message([&] { evaluate_on_logs(model, swing_logs(), swing_schema(), nullptr, {}, 1); }),
              HasSubstr("dq, lost"));
}

}  // namespace
}  // namespace nlo::trainer

// SPDX-License-Identifier: MIT
// Messages of validation for each field of each structure. A row breaks one field of a valid model.
#include "codegen/model_file/validate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <ostream>
#include <string>

#include "codegen/model/latent_step.h"
#include "codegen/structures/linear_latent_fields.h"
#include "tests/codegen/example_models.h"
#include "tests/codegen/flown.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string message_of(const Model& model) {
  return thrown_message([&] { validate(model); });
}

struct Row {
  const char* what;
  Model (*model)();
  std::function<void(Model&)> corrupt;
  const char* message;  ///< part of the expected message
};

std::ostream& operator<<(std::ostream& out, const Row& row) {
  return out << row.what;
}

Model sure_model() {
  return with_error(tiny_model(), 3);
}

class BadModel : public testing::TestWithParam<Row> {};

TEST_P(BadModel, IsRefusedWithItsFieldAndTheRemedy) {
  Model m = GetParam().model();
  ASSERT_EQ(message_of(m), "no error");
  GetParam().corrupt(m);
  EXPECT_THAT(message_of(m), testing::HasSubstr(GetParam().message));
}

const Row kRows[] = {
    {"LuenbergerOfAnAngle", luenberger_model, [](Model& m) { m.outputs[0].wrap = 6.283185307179586; },
     "outputs[0].wrap is 6.283185307179586; only a KKL observer can follow an unwrapped angle"},
    {"LuenbergerStart", luenberger_model,
     [](Model& m) {
       m.initial_latent = m.latent_max = Eigen::Vector3d::Ones();
       m.latent_min = -m.latent_max;
     },
     "initial_latent has 3 entries; it must have 2 (n_x"},
    {"RelativeOutputThatIsNotThere", rig_model, [](Model& m) { linear_latent(m)->relative_outputs = {2}; },
     "relative_outputs[0] is 2; write numbers of outputs, from 0 to 1, in increasing order"},
    {"FallbackOfNoOutput", fallback_model, [](Model& m) { inverse_map(m)->fallback.outputs[0] = 2; },
     "inverse_map.fallback.outputs[0] is 2; write numbers of outputs, from 0 to 1, in increasing order"},
    {"FallbackOfAnotherShape", fallback_model, [](Model& m) { inverse_map(m)->fallback.rows.resize(1, 3); },
     "inverse_map.fallback.rows is 1 x 3; it must be 1 x 13"},
    {"FallbackWithoutReach", fallback_model, [](Model& m) { inverse_map(m)->fallback.reach(0) = 0.0; },
     "inverse_map.fallback.reach[0] is 0"},
    {"FallbackOfAnAngle", fallback_model, [](Model& m) { m.states[1].wrap = 6.283185307179586; }, "which wraps"},
    {"FallbackThatOverflows", fallback_model, [](Model& m) { inverse_map(m)->fallback.offset(0) = 1e31; },
     "inverse_map.fallback.rows[0] may add up to 1e+31"},
    {"FallbackOfGates", gated_model,
     [](Model& m) {
       Network& gates = std::get<Gated>(m.structure).gates;
       gates.fallback = {{0}, Eigen::MatrixXd::Zero(1, 7), Eigen::VectorXd::Zero(1), Eigen::VectorXd::Ones(1)};
     },
     "gates has no fallback, only inverse_map has one"},
    {"FeatureClockOfAnotherSize", clocked_model, [](Model& m) { inverse_map(m)->feature_clocks.pop_back(); },
     "inverse_map.feature_clocks has 12 entries; it must have 13"},
    {"FeatureClockThatIsDriven", clocked_model, [](Model& m) { inverse_map(m)->feature_clocks[7] = 2; },
     "inverse_map.feature_clocks[7] is 2; it must be -1 or a row of z that is a clock"},
    {"FeatureClockBehindZ", clocked_model, [](Model& m) { inverse_map(m)->feature_clocks[7] = 5; },
     "inverse_map.feature_clocks[7] is 5; it must be -1"},
    {"FeatureClockThatStartsElsewhere", clocked_model, [](Model& m) { m.initial_latent(4) = 0.5; },
     "inverse_map.feature_clocks[7] is 4; it must be -1"},
    {"FeatureClocksOfGatedUnits", gated_model, [](Model& m) { inverse_map(m)->feature_clocks.assign(7, -1); },
     "inverse_map.feature_clocks belongs to the inverse_map of structure kkl; leave it out"},
    {"RelativeOutputTwice", rig_model,
     [](Model& m) {
       linear_latent(m)->relative_outputs = {1, 1};
     },
     "relative_outputs[1] is 1"},
    {"MonitorOfAnotherSize", watched_model, [](Model& m) { m.monitor->prediction = Eigen::MatrixXd::Zero(1, 3); },
     "monitor.prediction is 1 x 3; it must be 1 x 4"},
    {"MonitorWithoutWindows", watched_model, [](Model& m) { m.monitor->windows_s.resize(0); },
     "monitor.windows_s has 0 numbers; it must have 1 to 8"},
    {"MonitorLimitOfZero", watched_model, [](Model& m) { m.monitor->variance_limit(0, 1) = 0.0; },
     "monitor.variance_limit"},
    {"MonitorLimitNotFinite", watched_model, [](Model& m) { m.monitor->latent_limit(0) = kNaN; },
     "monitor.latent_limit[0] is not finite"},
    {"MonitorGateOfZero", watched_model, [](Model& m) { m.monitor->gate = 0.0; },
     "monitor.gate is 0; it must be positive"},
    {"MonitorReferenceSensor", watched_model, [](Model& m) { m.monitor->reference_sensor(0) = 1.0; },
     "monitor.reference_sensor[0] is 1; it must be from 0 to 0"},
    {"MonitorReferenceSensorBetween", watched_rig_model, [](Model& m) { m.monitor->reference_sensor(0) = 0.5; },
     "monitor.reference_sensor has a number that is not an integer"},
    {"MonitorEqual", watched_model, [](Model& m) { m.monitor->most_equal(0) = 65536.0; },
     "monitor.most_equal[0] is 65536; it must be from 0 to 65534"},
    {"MonitorReplacesOutputs", watched_rig_model, [](Model& m) { m.monitor->replaces.resize(1); }, "monitor.replaces"},
    {"MonitorReplacesHalf", watched_rig_model, [](Model& m) { m.monitor->replaces(0) = 0.5; },
     "monitor.replaces[0] is 0.5; it must be 0 or 1"},
    {"MonitorArmedNever", watched_model, [](Model& m) { m.monitor->armed_after_s = 1e9; },
     "monitor.armed_after_s is 1000000000; it must be at most 1000000 sample periods"},
    {"SaturationBelowZero", saturating_model, [](Model& m) { m.saturation = -0.5; },
     "saturation is -0.5; it must be a positive number of half ranges"},
    {"SaturationNotFinite", saturating_model, [](Model& m) { m.saturation = kNaN; }, "saturation is nan; it must be"},
    {"SaturationWithoutAMap", luenberger_model, [](Model& m) { m.saturation = 0.5; },
     "saturation exists only for structure kkl, but this model is luenberger; leave it out"},
    {"ErrorWithoutAMap", luenberger_model, [](Model& m) { m.error.emplace(); },
     "error reads the last hidden layer of inverse_map, but this model has no hidden layer"},
    {"ErrorOfOneLayer", linear_model, [](Model& m) { m.error.emplace(); }, "error reads the last hidden layer"},
    {"ErrorShape", sure_model, [](Model& m) { m.error->weights.conservativeResize(1, 7); },
     "error.weights is 1 x 7; it must be 1 x 8 (n_x x twice the neurons of the last hidden layer)"},
    {"ErrorNotFinite", sure_model, [](Model& m) { m.error->bias(0) = kNaN; }, "error.bias[0] is not finite"},
    {"ErrorRangeFalls", sure_model, [](Model& m) { m.error->log_max(0) = -7.5; },
     "and error.log_max[0] is -7.5; the first must be the smaller one, and both within +-60"},
    {"ErrorTooLarge", sure_model, [](Model& m) { m.error->log_max(0) = 60.5; }, "error.log_max[0] is 60.5"},
    {"ErrorFactorZero", sure_model, [](Model& m) { m.error->factor_68(0) = 0.0; }, "error.factor_68[0] is 0 and"},
    {"ErrorFactorsFall", sure_model, [](Model& m) { m.error->factor_95(0) = 0.5; },
     "error.factor_95[0] is 0.5; the first must be the smaller one, and both from 0.001 to 1000"},
    {"StateMatrixShape", luenberger_model,
     [](Model& m) { std::get<Luenberger>(m.structure).state_matrix.conservativeResize(2, 1); },
     "luenberger.state_matrix is 2 x 1; it must be 2 x 2"},
    {"OutputMatrixShape", luenberger_model,
     [](Model& m) { std::get<Luenberger>(m.structure).output_matrix = Eigen::Matrix2d::Identity(); },
     "luenberger.output_matrix is 2 x 2; it must be 1 x 2 (n_y x n_x)"},
    {"GainNotFinite", luenberger_model, [](Model& m) { std::get<Luenberger>(m.structure).gain(1, 0) = kNaN; },
     "luenberger.gain[1][0] is not finite"},
    {"WrapOfNoTurn", rig_model, [](Model& m) { m.outputs[0].wrap = 1e-8; },
     "outputs[0].wrap is 1e-08 and its range reaches 3.14"},
    {"ComputedOfAnUnknown", computed_model, [](Model& m) { m.outputs[2].expression = "y1 * current"; },
     "output \"power\": expression \"y1 * current\" reads \"current\""},
    {"ComputedOfAnAngle", computed_model, [](Model& m) { m.outputs[0].wrap = 6.28; },
     "reads \"y1\": expected a measured output that does not wrap"},
    {"ComputedBeforeMeasured", computed_model, [](Model& m) { std::swap(m.outputs[1], m.outputs[2]); },
     "\"y2\" is measured"},
    {"ComputedByADivision", computed_model, [](Model& m) { m.outputs[2].expression = "y1 / voltage"; },
     "at \"voltage\""},
    {"ComputedOfWhatMayBeMissing", computed_model,
     [](Model& m) {
       m.failures.outputs = {1, 2};
     },
     "may_fail.outputs lacks 3"},
    {"ComputedInput", computed_model, [](Model& m) { m.inputs[0].expression = "y1"; }, "inputs[0].expression is"},
    {"StalenessThatIsGoneAtOnce", failing_rig_model, [](Model& m) { m.failures.staleness_s = 3e-39; },
     "may_fail.staleness_s is 3e-39; it must be from 0.001 to 1e+06 sample periods"},
    {"StalenessThatNeverComes", failing_rig_model, [](Model& m) { m.failures.staleness_s = 1e9; },
     "may_fail.staleness_s is 1000000000; it must be from"},
    {"PeriodOfAnInput", commanded_model, [](Model& m) { m.inputs[0].period_s = 0.1; },
     "inputs[0].period_s is 0.1; only an output has a period of its own"},
    {"PeriodOfEverySample", rig_model, [](Model& m) { m.outputs[1].period_s = m.sample_period_s; },
     "outputs[1].period_s is 0.004; it must be from 1.5 to 5000 sample periods of 0.004 s"},
    {"PeriodThatIsNotCounted", rig_model, [](Model& m) { m.outputs[1].period_s = 1e4; },
     "outputs[1].period_s is 10000; it must be from 1.5 to 5000 sample periods"},
    {"PeriodOfAComputedOutput", computed_model, [](Model& m) { m.outputs[2].period_s = 0.1; },
     "a computed output has the period of its parts"},
    {"OutputRangeAtTheEndOfFloat", tiny_model, [](Model& m) { m.output_max(0) = 1e38; },
     "output_max[0] is 1e+38; float32 requires them within"},
    {"InputRangeAtTheEndOfFloat", commanded_model, [](Model& m) { m.input_max(0) = 3e38; },
     "input_max[0] is 3e+38; float32 requires them within"},
    {"InjectionOfASmallOutput", tiny_model,
     [](Model& m) {
       m.output_min(0) = -1e-10;
       m.output_max(0) = 1e-10;
       linear_latent(m)->output_injection(0, 0) = 1e37;
     },
     "output_injection[0] reaches 1e+37"},
    {"StartThatARuntimeTakesForSpoilt", general_model, [](Model& m) { m.initial_latent(2) = 1e36; },
     "initial_latent[2] is 1e+36; float32 requires it within"},
    {"LuenbergerStartThatARuntimeTakesForSpoilt", luenberger_model, [](Model& m) { m.initial_latent(0) = -1e36; },
     "initial_latent[0] is -1e+36"},
    {"SaturationThatFloatLacks", saturating_model, [](Model& m) { m.saturation = 1e38; },
     "saturation is 1e+38 and lets T* read z[0] from"},
    {"MonitorLimitBelowFloat", watched_model, [](Model& m) { m.monitor->variance_limit(0, 1) = 1e-300; },
     "monitor.variance_limit[0][1] is 1e-300; it must be from 1e-12"},
    {"MonitorLimitThatNothingPasses", watched_model, [](Model& m) { m.monitor->mean_limit(0, 0) = 1e30; },
     "monitor.mean_limit[0][0] is 1e+30; it must be from 1e-12 to 1e+12"},
    {"MonitorMeanAboveAll", watched_model, [](Model& m) { m.monitor->mean_limit(0, 0) = 1.0; },
     "monitor.mean_limit has 1, but the statistic is at most 1, so this alarm could never be raised"},
    {"MonitorShareAboveAll", watched_model, [](Model& m) { m.monitor->missing_limit(0) = 1.4; },
     "monitor.missing_limit has 1.4, but the statistic is at most 1"},
    {"MonitorVarianceAboveAll", watched_model, [](Model& m) { m.monitor->variance_limit(0, 1) = 25.0; },
     "monitor.variance_limit has 25, but the statistic is at most 25"},
    {"MonitorPlaceLimitBelowFloat", watched_model, [](Model& m) { m.monitor->latent_limit(1) = 1e-40; },
     "monitor.latent_limit[1] is 1e-40"},
    {"MonitorMissingLimitBelowFloat", watched_model, [](Model& m) { m.monitor->missing_limit(0) = 1e-40; },
     "monitor.missing_limit[0] is 1e-40"},
    {"MonitorVarianceOfNothing", watched_model, [](Model& m) { m.monitor->least_variance(0) = 1e-30; },
     "monitor.least_variance[0] is 1e-30"},
    {"MonitorDeviationOfNothing", watched_model, [](Model& m) { m.monitor->deviation(0) = 1e-40; },
     "monitor.deviation[0] is 1e-40"},
    {"MonitorLatentDeviationOfNothing", watched_model, [](Model& m) { m.monitor->latent_deviation(1) = 1e-40; },
     "monitor.latent_deviation[1] is 1e-40"},
    {"MonitorWindowThatNeverEnds", watched_model, [](Model& m) { m.monitor->windows_s(1) = 1e300; },
     "monitor.windows_s / sample period[1] is"},
    {"MonitorGateOfNothing", watched_model, [](Model& m) { m.monitor->gate = 1e-20; }, "monitor.gate[0] is 1e-20"},
    {"WrapThatFloatLacks", rig_model, [](Model& m) { m.outputs[0].wrap = 1e39; }, "outputs[0].wrap is 1e+39; float32"},
    {"OutputRangeThatFloatLacks", tiny_model, [](Model& m) { m.output_max(0) = 1e39; },
     "output_max[0] is 1e+39; float32 requires them within"},
    {"PeriodThatFloatLacks", tiny_model, [](Model& m) { m.sample_period_s = 1e-46; },
     "sample_period_s is 1e-46; float32 requires it from 1e-30"},
    {"InjectionAtTheEndOfFloat", tiny_model, [](Model& m) { linear_latent(m)->output_injection(0, 0) = 5e29; },
     "output_injection[0] and the ranges of the readings let z[0] reach"},
    {"InjectionThatOverflowsLater", tiny_model, [](Model& m) { linear_latent(m)->output_injection(1, 0) = 1e30; },
     "let z[1] reach"},
    {"StartThatOverflows", tiny_model, [](Model& m) { m.initial_latent(0) = 1e30; },
     "let z[0] reach 1e+30; it must stay below 1e+30"},
    {"MapThatOverflows", tiny_model, [](Model& m) { inverse_map(m)->layers[0].weights(1, 0) = 1e32; },
     "inverse_map.layers[0].weights[1] may add up to"},
    {"GatedMapThatOverflows", gated_model, [](Model& m) { inverse_map(m)->output_mean(0) = 1e31; },
     "may add up to 1e+31"},
    {"NotHurwitzReal", luenberger_model,
     [](Model& m) { std::get<Luenberger>(m.structure).gain = Eigen::Vector2d(0.0, -5.0); },
     "luenberger.gain leaves A - G C with the eigenvalue 0.8612"},
    {"NotHurwitzPair", luenberger_model,
     [](Model& m) { std::get<Luenberger>(m.structure).gain = Eigen::Vector2d(-1.0, 2.0); },
     "with the eigenvalue 0.35 + 2.362i; its real part must be negative"},
    {"GainTooFast", luenberger_model,
     [](Model& m) { std::get<Luenberger>(m.structure).gain = Eigen::Vector2d(200.0, 2.0); },
     "the eigenvalue -200, too fast for a Runge-Kutta step of 0.03 s"},
    {"NonlinearityShape", luenberger_model,
     [](Model& m) { std::get<Luenberger>(m.structure).nonlinearity.layers[0].weights.conservativeResize(8, 3); },
     "luenberger.nonlinearity.layers[0].weights is 8 x 3; it must be 8 x 2"},
    {"DynamicsShape", general_model,
     [](Model& m) { std::get<General>(m.structure).dynamics.features = Eigen::MatrixXd::Identity(5, 3); },
     "dynamics.features is 5 x 3; it must be 5 x 5 (n_u x (n_z + n_y))"},
    {"DynamicsOutputs", general_model,
     [](Model& m) { std::get<General>(m.structure).dynamics.layers[1].weights.conservativeResize(2, 12); },
     "dynamics.layers[1].weights is 2 x 12; it must be 3 x 12"},
    {"DynamicsPathNotFinite", general_model,
     [](Model& m) { std::get<General>(m.structure).dynamics.skip(2, 1) = kNaN; }, "dynamics.skip[2][1] is not finite"},
    {"GeneralMapReadsOutput", general_model,
     [](Model& m) { inverse_map(m)->features = Eigen::MatrixXd::Identity(3, 5); },
     "inverse_map.features is 3 x 5; it must be 3 x 3 (n_u x n_z)"},
    {"GeneralStart", general_model, [](Model& m) { m.initial_latent.resize(0); }, "initial_latent is empty"},
    {"GatesShape", gated_model,
     [](Model& m) { std::get<Gated>(m.structure).gates.layers[0].weights.conservativeResize(9, 7); },
     "gates.layers[0].weights is 9 x 7; it must be 10 x 7"},
    {"CandidateLayers", gated_model,
     [](Model& m) {
       Network& n = std::get<Gated>(m.structure).candidate;
       n.layers.push_back({Eigen::MatrixXd::Identity(5, 5), Eigen::VectorXd::Zero(5)});
     },
     "candidate has 2 layers; it must have exactly one layer"},
    {"GatesPath", gated_model, [](Model& m) { std::get<Gated>(m.structure).gates.skip = Eigen::MatrixXd::Zero(10, 7); },
     "gates has 1 layers and a linear path"},
    {"GatesOverflow", gated_model, [](Model& m) { std::get<Gated>(m.structure).gates.layers[0].weights(3, 6) = 1e30; },
     "gates.layers[0].weights[3] may add up to"},
    {"GatedStart", gated_model, [](Model& m) { m.initial_latent(1) = 1.5; },
     "initial_latent[1] is 1.5; a gated unit is between -1 and 1"},
    {"ContractionTooFast", contracting_gated_model,
     [](Model& m) { std::get<Gated>(m.structure).contraction.rate *= 1.001; }, "contraction.rate is"},
    {"ContractionOfOtherWeights", contracting_gated_model,
     [](Model& m) { std::get<Gated>(m.structure).candidate.layers[0].weights(2, 1) += 1.0; },
     "gates and candidate only prove none in that metric; remove the contraction"},
    {"ContractionInAWiderRange", contracting_gated_model, [](Model& m) { m.output_max(0) += 100.0; },
     "contraction.rate is"},
    {"ContractionMetric", contracting_gated_model,
     [](Model& m) { std::get<Gated>(m.structure).contraction.metric.conservativeResize(4); },
     "contraction.metric has 4 entries"},
    {"ContractionMetricZero", contracting_gated_model,
     [](Model& m) { std::get<Gated>(m.structure).contraction.metric(1) = 0.0; }, "contraction.metric[1] is 0"},
    {"EmptyPath", paper_model, [](Model& m) { inverse_map(m)->skip.resize(2, 0); }, "inverse_map.skip is 2 x 0"},
    {"FlightInputs", [] { return flown(commanded_model(), 2, 20, 0.5); },
     [](Model& m) { m.flight.runs[1].inputs = Eigen::MatrixXi::Zero(0, 20); }, "flight.runs[1] has"},
    {"InputsEmpty", driven_model, [](Model& m) { std::get<DrivenKkl>(m.structure).inputs.clear(); },
     "drive.inputs is empty"},
    {"InputName", driven_model, [](Model& m) { std::get<DrivenKkl>(m.structure).inputs[1].name = "u-1"; },
     "drive.inputs[1].name is not an identifier"},
    {"InputTwice", driven_model, [](Model& m) { std::get<DrivenKkl>(m.structure).inputs[1].name = "torque"; },
     "drive.inputs[0].name and drive.inputs[1].name are both \"torque\""},
    {"InputAngle", driven_model, [](Model& m) { std::get<DrivenKkl>(m.structure).inputs[1].wrap = 1.0; },
     "drive.inputs[1].wrap is 1"},
    {"InputHold", driven_model, [](Model& m) { std::get<DrivenKkl>(m.structure).input_hold = Hold::kRk4; },
     "drive.input_hold is unknown"},
    {"InputFieldShape", driven_model,
     [](Model& m) { std::get<DrivenKkl>(m.structure).input_field.weights.conservativeResize(2, 2); },
     "drive.input_field.weights is 2 x 2; it must be 4 x 2"},
    {"InputFieldBias", driven_model,
     [](Model& m) { std::get<DrivenKkl>(m.structure).input_field.bias.conservativeResize(2); },
     "drive.input_field.bias has 2 entries; it must have 4 (n_x n_u)"},
    {"ForwardMapInputs", driven_model,
     [](Model& m) { std::get<DrivenKkl>(m.structure).forward_map.features = Eigen::MatrixXd::Ones(2, 3); },
     "drive.forward_map.features is 2 x 3; it must be 2 x 2 (n_u x n_x)"},
    {"ForwardMapOutputs", driven_model,
     [](Model& m) { std::get<DrivenKkl>(m.structure).forward_map.output_scale.conservativeResize(2); },
     "drive.forward_map.output_scale has 2 entries; it must have 3"},
    {"DrivenNotHurwitz", driven_model, [](Model& m) { linear_latent(m)->eigenvalues(0) = 0.5; },
     "eigenvalues[0] is 0.5"},
};

/// Drives readings between the ends of their ranges, in the time of each mode and at random, and returns the share of
/// the bound that z reaches.
double share_reached(const Model& m) {
  const StepMatrices step = latent_step(m, m.sample_period_s);
  const Eigen::MatrixXd a = block_diagonal(m, step.a_minus_1) + Eigen::MatrixXd::Identity(m.nz(), m.nz());
  const Eigen::VectorXd low = reading_min(m), high = reading_max(m), largest = largest_latent(m);
  double share = 0.0;
  for (int pace = 1; pace < 400; pace += 1 + pace / 4) {
    Eigen::VectorXd z = steady_gain(m) * high + m.initial_latent, y = high;
    for (int k = 0; k < 4000; ++k) {
      const Eigen::VectorXd next = k / pace % 2 == 0 ? low : high;
      z = a * z + step.b0 * y + step.b1 * next;
      y = next;
      share = std::max(share, z.cwiseAbs().cwiseQuotient(largest).maxCoeff());
    }
  }
  return share;
}

TEST(LargestLatent, IsWithinAnOrderOfMagnitudeOfReachedStates) {
  for (const Model& m : {tiny_model(), rig_model(), paper_model(), hold_model("rk4"), hold_model("zero_order"),
                         commanded_model(), failing_rig_model()}) {
    const double share = share_reached(m);
    EXPECT_LT(share, 1.0) << m.name;
    EXPECT_GT(share, 0.1) << m.name << ": the bound is so loose that valid models are refused";
  }
}

INSTANTIATE_TEST_SUITE_P(Table, BadModel, testing::ValuesIn(kRows),
                         [](const auto& row) { return std::string(row.param.what); });

}  // namespace
}  // namespace nlo::codegen

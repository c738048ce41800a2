// SPDX-License-Identifier: MIT
// The stated errors of an export's arithmetic, and the refusals of --max-error.
#include "codegen/replay/export_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "codegen/model_file/model_file.h"
#include "codegen/targets/error_limits.h"
#include "tests/codegen/example_models.h"
#include "tests/codegen/flown.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {
namespace {

using testing::HasSubstr;
using testing::Not;

ExportError error_in(const Model& m, ScalarType scalar) {
  ExportOptions options;
  options.scalar = scalar;
  return PreparedExport(m, options).error();
}

// Readings that a double pendulum cannot produce drive the filter of its hidden joint so hard that float and double
// drift apart by whole turns. A replay whose tolerance is this difference would accept a wrong parameter.
TEST(ExportError, AReplayOfAHiddenJointFindsAWrongParameter) {
  const Model m = hidden_joint_model();
  Model wrong = m;
  std::get<Prior>(wrong.structure).equations.parameters[0].second *= 1.02;  // m1
  const ReplayRun run = run_replay(PreparedExport(m));
  const Eigen::MatrixXd off = (run.exported_x_hat - run.x_hat).cwiseAbs();
  ReferenceObserver<double> observer(wrong);
  Eigen::VectorXd most = Eigen::VectorXd::Zero(m.nx());
  for (Eigen::Index k = 0; k < run.x_hat.cols(); ++k) {
    const double dt_s = run.inputs.dt_s(k) == 0.0 ? m.sample_period_s : run.inputs.dt_s(k);
    observer.step(run.inputs.outputs.col(k), run.inputs.inputs.col(k), dt_s);
    most = most.cwiseMax((observer.estimate() - run.x_hat.col(k)).cwiseAbs());
  }
  // The hidden angle and its speed: float is some 1e-4 of their size away, an inertia that is 2 % wrong some per
  // cent.
  for (const Eigen::Index i : {1, 3}) {
    EXPECT_LT(off.row(i).maxCoeff(), 0.1 * most(i)) << i;
    EXPECT_LT(off.row(i).maxCoeff(), 0.02 * run.x_hat.row(i).cwiseAbs().maxCoeff()) << i;
  }
}

TEST(ExportError, IsOfTheOrderOfTheArithmetic) {
  // Rounding units of double and float, a few layers with their tanh; int16 has 12 bits left for weights.
  constexpr double kDouble = 1e-13, kFloat = 1e-5, kInt16 = 2e-3;
  for (const Model& m : example_models()) {
    const double largest = run_replay(PreparedExport(m)).x_hat.cwiseAbs().maxCoeff();
    const PreparedExport prepared(m);
    const auto in = [&](ScalarType scalar) {
      ExportOptions options;
      options.scalar = scalar;
      return prepared.with(options).error().max.maxCoeff() / largest;
    };
    const double in_double = in(ScalarType::kDouble), in_float = in(ScalarType::kFloat);
    EXPECT_LT(in_double, kDouble) << m.name;
    EXPECT_LT(in_float, kFloat) << m.name;
    EXPECT_GT(in_float, kDouble) << m.name;
    if (structure_name(m) != "kkl" || inverse_map(m)->activation == Activation::kSilu) continue;
    const double in_int16 = in(ScalarType::kInt16);
    EXPECT_LT(in_int16, kInt16) << m.name;
    EXPECT_GT(in_int16, in_float) << m.name;
  }
}

TEST(ExportError, IsFarBelowTheEstimationErrorForTheShippedObserver) {
  const Model m = read_model(NLO_SOURCE_DIR "/examples/models/van_der_pol.json");
  constexpr double kBound = 1e-3;  // a hundredth of the estimation error, 0.11 rms
  EXPECT_LT(error_in(m, ScalarType::kInt16).max.maxCoeff(), kBound);
}

TEST(ExportError, IsMeasuredOnTenThousandSamplesInTheDomainOrMore) {
  for (const Model& m : {paper_model(), rig_model(), luenberger_model(), driven_model()}) {
    const ExportError error = error_in(m, ScalarType::kFloat);
    EXPECT_GE(error.samples, 10000) << m.name;
    EXPECT_EQ(error.recorded, 0) << m.name;
  }
}

TEST(ExportError, IsMeasuredOnTheSameNumberOfSamplesForASmallDomain) {
  // In steady state z = y / |lambda|. This domain belongs to y from 2 to 2.08, which tones about the middle of the
  // range of y do not reach.
  Model m = paper_model();
  m.latent_min = 0.50 * m.latent_max;
  m.latent_max *= 0.52;
  const ReplayRun run = run_replay(PreparedExport(m));
  EXPECT_LT(std::count(run.in_domain.begin(), run.in_domain.end(), true), 20)
      << "the golden replay has few samples there";
  EXPECT_GE(error_in(m, ScalarType::kInt16).samples, 10000);
}

TEST(ExportError, RefusesTooFewSamplesAndNamesTheRemedy) {
  Model m = tiny_model();
  m.latent_min = Eigen::Vector2d(0.5, -0.9).cwiseProduct(m.latent_max);  // y cannot be high and low at the same time
  m.latent_max = Eigen::Vector2d(0.6, -0.8).cwiseProduct(m.latent_max);
  for (const char* part : {"samples lie in the domain of \"tiny\"", "needs at least 1000", "train again", "latent_min"})
    EXPECT_THAT(thrown_message([&] { error_in(m, ScalarType::kFloat); }), HasSubstr(part));
}

TEST(ExportError, CountsTheSamplesOfRecordedFlights) {
  const Model m = flown(paper_model(), 24, 500, 0.8);
  const ExportError error = error_in(m, ScalarType::kFloat);
  EXPECT_EQ(error.recorded, 12000);
  EXPECT_THAT(error_table(PreparedExport(m)), HasSubstr("12,000 from flights that training recorded"));
}

TEST(ExportError, RefusesAModelThatIsInaccurateOnRecordedFlightsOnly) {
  const Model m = flown(activation_model("tanh"), 24, 500);
  ExportOptions options;
  options.scalar = ScalarType::kInt16;
  const ReplayRun run = run_replay(PreparedExport(m, options));
  Eigen::VectorXd of_tones = Eigen::VectorXd::Zero(m.nx());
  for (std::size_t k = 0; k < run.in_domain.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    if (run.in_domain[k]) of_tones = of_tones.cwiseMax((run.exported_x_hat.col(at) - run.x_hat.col(at)).cwiseAbs());
  }
  const ExportError error = PreparedExport(m, options).error();
  EXPECT_GT(error.max(0), 1.1 * of_tones(0));
  EXPECT_THAT(beyond_limits(PreparedExport(m, options), 1.05 * of_tones),
              HasSubstr("within its domain, but --max-error allows only"));
}

TEST(ExportError, StatesTheErrorOutsideOfTheDomainWithoutALimit) {
  Model m = paper_model();
  m.latent_min *= 0.3;  // tones at full amplitude leave it; int16 stays at its edge
  m.latent_max *= 0.3;
  ExportOptions options;
  options.scalar = ScalarType::kInt16;
  const ExportError error = PreparedExport(m, options).error();
  EXPECT_GT(error.outside, 20);
  EXPECT_GT(error.max_outside.maxCoeff(), 50.0 * error.max.maxCoeff());
  EXPECT_EQ(beyond_limits(PreparedExport(m, options), 1.01 * error.max), "");
  EXPECT_THAT(error_table(PreparedExport(m, options)), HasSubstr(fmt::format("{:.1e}\n", error.max_outside(1))));
}

TEST(ExportError, QuantilesAreOrdered) {
  for (const ScalarType scalar : {ScalarType::kFloat, ScalarType::kInt16}) {
    const ExportError error = error_in(flown(rig_model(), 4, 500), scalar);
    for (int i = 0; i < 3; ++i) {
      EXPECT_LT(error.rms(i), error.quantile999(i));
      EXPECT_LE(error.quantile999(i), error.max(i));
    }
  }
}

TEST(Quantile, IsTheValueAtItsRank) {
  std::vector<double> values;
  // 1 to 10,000, shuffled.
  for (int k = 0; k < 10000; ++k) values.push_back(static_cast<double>((k * 7919) % 10000 + 1));
  EXPECT_EQ(quantile(values, 0.999), 9990.0);
  EXPECT_EQ(quantile(values, 0.5), 5000.0);
  EXPECT_EQ(quantile(values, 1.0), 10000.0);
  EXPECT_EQ(quantile({3.0}, 0.999), 3.0);
  EXPECT_EQ(quantile({}, 0.999), 0.0);
}

TEST(ErrorLimits, ApplyToAllStatesOrToOne) {
  const Model m = paper_model();
  EXPECT_EQ(error_limits("0.01", m), Eigen::Vector2d(0.01, 0.01));
  EXPECT_EQ(error_limits("x2=1e-3,x1=2", m), Eigen::Vector2d(2.0, 1e-3));
  EXPECT_EQ(error_limits("x2=1", m)(0), std::numeric_limits<double>::infinity());
}

std::string error_of(const std::string& text) {
  return thrown_message([&] { error_limits(text, paper_model()); });
}

TEST(ErrorLimits, RefuseInvalidTexts) {
  for (const char* text : {"", "abc", "-1", "0", "nan", "inf", "1e999", "0,5", "x1=", "=1", "x1=1,", "x1=0x1p3"})
    EXPECT_THAT(error_of(text), HasSubstr("--max-error")) << text;
  EXPECT_THAT(error_of("x3=1"), HasSubstr("there is no state \"x3\"; the model estimates x1, x2"));
  EXPECT_THAT(error_of("x1=1,x1=2"), HasSubstr("given twice"));
}

TEST(ErrorLimits, ErrorsNameTheStateTheErrorAndTheRemedy) {
  const Model m = paper_model();
  ExportOptions options;
  options.scalar = ScalarType::kInt16;
  const ExportError error = PreparedExport(m, options).error();
  EXPECT_EQ(beyond_limits(PreparedExport(m, options), 1.01 * error.max), "");
  const std::string refusal = beyond_limits(PreparedExport(m, options), Eigen::Vector2d(1.0, 0.99 * error.max(1)));
  for (const char* part :
       {"x2 [m/s] has an error of", "in int16", "nothing is written", "--scalar float has an error of", "train"})
    EXPECT_THAT(refusal, HasSubstr(part));
}

}  // namespace
}  // namespace nlo::codegen

// SPDX-License-Identifier: MIT
// What an export says about its own arithmetic.
#include "codegen/error_limits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "codegen/error.h"
#include "codegen/model_file.h"
#include "tests/codegen/example_models.h"

namespace nlo::codegen {
namespace {

using testing::HasSubstr;

ExportError error_in(const Model& m, ScalarType scalar) {
  ExportOptions options;
  options.scalar = scalar;
  return export_error(m, options);
}

TEST(ExportError, IsOfTheOrderOfTheArithmetic) {
  // Rounding units of double and float, a few layers of them; 12 of int16's bits are left for weights.
  constexpr double kDouble = 1e-13, kFloat = 1e-5, kInt16 = 2e-3;
  for (const Model& m : example_models()) {
    const double largest = run_replay(m, {}).x_hat.cwiseAbs().maxCoeff();
    const double in_double = error_in(m, ScalarType::kDouble).max.maxCoeff() / largest;
    const double in_float = error_in(m, ScalarType::kFloat).max.maxCoeff() / largest;
    // The runtime's rational tanh, too, is within 5e-7 of tanh.
    EXPECT_LT(in_double, kFloat) << m.name;
    EXPECT_LT(in_float, kFloat) << m.name;
    EXPECT_GT(in_float, kDouble) << m.name;
    if (structure(m) != "kkl" || m.inverse_map.activation == "silu") continue;
    const double in_int16 = error_in(m, ScalarType::kInt16).max.maxCoeff() / largest;
    EXPECT_LT(in_int16, kInt16) << m.name;
    EXPECT_GT(in_int16, in_float) << m.name;
  }
}

TEST(ExportError, OfTheShippedObserverIsFarBelowItsEstimationError) {
  const Model m = read_model(NLO_SOURCE_DIR "/examples/models/van_der_pol.json");
  constexpr double kBound = 1e-3;  // a hundredth of the estimation error, 0.11 rms
  EXPECT_LT(error_in(m, ScalarType::kInt16).max.maxCoeff(), kBound);
}

TEST(ExportError, IsMeasuredInsideTheDomain) {
  Model m = tiny_model();
  m.latent_min *= 0.05;  // the tones at full loudness leave it
  m.latent_max *= 0.05;
  const ReplayRun run = run_replay(m, {});
  EXPECT_GE(2 * export_error(run).samples, 400);
  for (std::size_t k = 0; k < run.in_domain.size(); ++k) {
    const Eigen::VectorXd z = run.z.col(static_cast<Eigen::Index>(k));
    EXPECT_EQ(run.in_domain[k], (z.array() >= m.latent_min.array()).all() && (z.array() <= m.latent_max.array()).all());
  }
}

TEST(ErrorLimits, AreOneForAllOrOneEach) {
  const Model m = paper_model();
  EXPECT_EQ(error_limits("0.01", m), Eigen::Vector2d(0.01, 0.01));
  EXPECT_EQ(error_limits("x2=1e-3,x1=2", m), Eigen::Vector2d(2.0, 1e-3));
  EXPECT_EQ(error_limits("x2=1", m)(0), std::numeric_limits<double>::infinity());
}

std::string error_of(const std::string& text) {
  try {
    error_limits(text, paper_model());
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(ErrorLimits, BadOnesAreRefused) {
  for (const char* text : {"", "abc", "-1", "0", "nan", "inf", "1e999", "0,5", "x1=", "=1", "x1=1,", "x1=0x1p3"})
    EXPECT_THAT(error_of(text), HasSubstr("--max-error")) << text;
  EXPECT_THAT(error_of("x3=1"), HasSubstr("there is no state \"x3\"; the model estimates x1, x2"));
  EXPECT_THAT(error_of("x1=1,x1=2"), HasSubstr("given twice"));
}

TEST(ErrorLimits, BeyondThemTheStateTheErrorAndTheMendAreNamed) {
  const Model m = paper_model();
  ExportOptions options;
  options.scalar = ScalarType::kInt16;
  const ExportError error = export_error(m, options);
  EXPECT_EQ(beyond_limits(m, options, error, 1.01 * error.max), "");
  const std::string refusal = beyond_limits(m, options, error, Eigen::Vector2d(1.0, 0.99 * error.max(1)));
  for (const char* part : {"x2 [m/s] is off by", "in int16", "nothing is written", "--scalar float is off by", "train"})
    EXPECT_THAT(refusal, HasSubstr(part));
}

}  // namespace
}  // namespace nlo::codegen

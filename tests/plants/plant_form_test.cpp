// SPDX-License-Identifier: MIT
// Linear expressions are recognised; expressions that only look linear are not.
#include "trainer/plants/plant_form.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/thrown_message.h"
#include "trainer/plants/linear.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;

std::unique_ptr<Plant> two_states(const std::vector<std::string>& derivative, const std::string& output) {
  PlantConfig config;
  config.states = {"p", "v"};
  config.derivative = derivative;
  config.output_names = {"y"};
  config.outputs = {output};
  config.parameters = {{"m", 0.7}, {"c", 0.3}, {"g", 9.81}};
  return make_plant(config);
}

Linearity recognised(const std::vector<std::string>& derivative, const std::string& output) {
  return recognise_linear(*two_states(derivative, output), Eigen::Vector2d(1.0, 2.0));
}

TEST(RecogniseLinear, FindsTheMatricesOfLinearExpressions) {
  const Linearity found = recognised({"v", "-(p - v / 3) / m - c * v * 2"}, "p + 0.5 * v");
  ASSERT_TRUE(found.plant);
  EXPECT_FALSE(found.affine);
  Eigen::Matrix2d a;
  a << 0.0, 1.0, -1.0 / 0.7, 1.0 / 2.1 - 0.6;
  EXPECT_LT((found.plant->a() - a).norm(), 1e-15);
  EXPECT_EQ(found.plant->c(), Eigen::RowVector2d(1.0, 0.5));
  EXPECT_EQ(found.plant->outputs().front().name, "y");
}

TEST(RecogniseLinear, RecognisesNonlinearPlants) {
  const std::vector<std::string> linear = {"v", "-p"};
  ASSERT_TRUE(recognised(linear, "p").plant) << "control";
  for (const char* nonlinear : {"-sin(p)", "-p - 1e-9 * p^3", "-p * v", "-abs(p)", "max(-50, min(50, -p))",
                                "-p / (1 + 1e-12 * v^2)", "abs(p) < 0.01 ? 0 : -p", "-sqrt(p)", "-sin(1e-6 * p)"}) {
    const Linearity found = recognised({"v", nonlinear}, "p");
    EXPECT_FALSE(found.plant) << nonlinear;
    EXPECT_FALSE(found.affine) << nonlinear;
  }
  EXPECT_FALSE(recognised(linear, "p^2").plant);
}

TEST(RecogniseLinear, DistinguishesConstantOffsetsFromNonlinearity) {
  const Linearity falling = recognised({"v", "-c * v - g"}, "p");
  EXPECT_FALSE(falling.plant);
  EXPECT_TRUE(falling.affine);
  EXPECT_TRUE(recognised({"v", "-p"}, "p - 0.2").affine);
}

TEST(RecogniseLinear, RecognisesTheBuiltInPlants) {
  for (const PlantEntry& entry : plant_registry()) {
    PlantConfig config;
    config.model = entry.name;
    const auto plant = make_plant(config);
    const Linearity found = recognise_linear(*plant, Eigen::VectorXd::Ones(plant->nx()));
    EXPECT_EQ(found.plant != nullptr, entry.name == "harmonic_oscillator") << entry.name;
  }
}

const Eigen::Vector2d kLow(-1.0, 2.0), kHigh(3.0, 5.0);

std::unique_ptr<Plant> driven_by(std::vector<std::vector<std::string>> input_field) {
  PlantConfig config;
  config.states = {"x1", "x2"};
  config.derivative = {"x2", "-x1"};
  config.outputs = {"x1"};
  for (std::size_t j = 0; j < input_field[0].size(); ++j) config.inputs.push_back("u" + std::to_string(j + 1));
  config.input_field = std::move(input_field);
  return make_plant(config);
}

std::string error_of(const Plant& plant) {
  return thrown_message([&] { affine_input_field(plant, kLow, kHigh); });
}

TEST(AffineInputField, EqualsBWithoutRoundingForALinearPlant) {
  const Eigen::MatrixXd b = (Eigen::Matrix2d() << 0.1, -0.3, 1.0 / 3.0, 7e-9).finished();
  const LinearPlant plant("driven", channels({"x1", "x2"}), channels({"y"}), Eigen::Matrix2d::Identity(),
                          Eigen::RowVector2d(1.0, 0.0), channels({"u1", "u2"}), b);
  const codegen::DenseLayer field = affine_input_field(plant, kLow, kHigh);
  EXPECT_EQ(field.weights, Eigen::MatrixXd(Eigen::MatrixXd::Zero(4, 2)));
  EXPECT_EQ(field.bias, Eigen::VectorXd(b.reshaped()));
}

TEST(AffineInputField, HasTheColumnsOfTheMatricesOfABilinearPlant) {
  const auto plant = driven_by({{"2 + 3*x1", "x2"}, {"-x1 + 4*x2", "5"}});
  const codegen::DenseLayer field = affine_input_field(*plant, kLow, kHigh);
  const Eigen::MatrixXd weights = (Eigen::MatrixXd(4, 2) << 3.0, 0.0, -1.0, 4.0, 0.0, 1.0, 0.0, 0.0).finished();
  constexpr double kFieldRounding = 1e-14;  // rounding of numbers up to 23
  EXPECT_LE((field.weights - weights).cwiseAbs().maxCoeff(), kFieldRounding);
  EXPECT_LE((field.bias - Eigen::Vector4d(2.0, 0.0, 0.0, 5.0)).cwiseAbs().maxCoeff(), kFieldRounding);

  const Eigen::Vector2d x(0.3, 4.0), u(-1.0, 2.0);
  const Eigen::MatrixXd g = (field.weights * x + field.bias).reshaped(2, 2);
  const Eigen::VectorXd sum = -plant->input_field(x, 0) + 2.0 * plant->input_field(x, 1);
  EXPECT_LE((g * u - sum).cwiseAbs().maxCoeff(), 10.0 * kFieldRounding);
}

TEST(AffineInputField, HasTheSlopeAlongAStateThatStartsAtOneValue) {
  const auto plant = driven_by({{"2 + 3*x1"}, {"-x1 + 4*x2"}});
  const codegen::DenseLayer field = affine_input_field(*plant, Eigen::Vector2d(-1.0, 2.0), Eigen::Vector2d(3.0, 2.0));
  const Eigen::Matrix2d weights = (Eigen::Matrix2d() << 3.0, 0.0, -1.0, 4.0).finished();
  EXPECT_LE((field.weights - weights).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_LE((field.bias - Eigen::Vector2d(2.0, 0.0)).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(AffineInputField, NamesTheInputAndTheDeviationOfAFieldThatIsNotAffine) {
  // Odd about the centre x1 = 1: differences across the box show its chord, but not its curvature.
  const std::string message = error_of(*driven_by({{"0", "0"}, {"1", "(x1 - 1)^3"}}));
  EXPECT_THAT(message, HasSubstr("plant expressions: the field of input u2 is not affine in the state: at x = ("));
  EXPECT_THAT(message,
              HasSubstr("it differs from the affine fit by 3.08"));  // chord 4 d minus d^3: 3.08 at d = 2 / sqrt 3
  EXPECT_THAT(error_of(*driven_by({{"0"}, {"max(x1, 2.5)"}})), HasSubstr("input u1 is not affine"));
  EXPECT_THAT(error_of(*driven_by({{"0"}, {"sqrt(x1)"}})), HasSubstr("input u1 is not affine"));  // NaN below 0
  EXPECT_EQ(error_of(*driven_by({{"0"}, {"x1*1e-3"}})), "no error");
  PlantConfig autonomous;
  autonomous.model = "sine_cosine";
  EXPECT_THAT(error_of(*make_plant(autonomous)), HasSubstr("has no input"));
}

TEST(AffineInputField, IsFoundFromDerivativesThatAreAffineInTheirInputs) {
  PlantConfig config;
  config.states = {"x1", "x2"};
  config.outputs = {"x1"};
  config.inputs = {"u1", "u2"};
  config.derivative = {"x2 + (2 + 3*x1)*u1 + x2*u2", "-x1 + (-x1 + 4*x2)*u1 + 5*u2"};
  const codegen::DenseLayer named = affine_input_field(*make_plant(config), kLow, kHigh);
  const codegen::DenseLayer field =
      affine_input_field(*driven_by({{"2 + 3*x1", "x2"}, {"-x1 + 4*x2", "5"}}), kLow, kHigh);
  constexpr double kFieldRounding = 1e-13;  // a difference of two derivatives with values up to 40
  EXPECT_LE((named.weights - field.weights).cwiseAbs().maxCoeff(), kFieldRounding);
  EXPECT_LE((named.bias - field.bias).cwiseAbs().maxCoeff(), kFieldRounding);

  for (const char* curved : {"-x1 + u1 + u2^2", "-x1 + u1*u2", "-x1 + u2 + sin(u1)", "-x1 + u2 + sqrt(u1)"}) {
    config.derivative[1] = curved;
    EXPECT_THAT(error_of(*make_plant(config)), HasSubstr("f(x, u) is not affine in its inputs: at x = (")) << curved;
  }
}

}  // namespace
}  // namespace nlo::trainer

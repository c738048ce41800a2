// SPDX-License-Identifier: MIT
#include "trainer/plants/affine_input_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codegen/base/error.h"
#include "trainer/plants/linear.h"
#include "trainer/plants/registry.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;

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
  try {
    affine_input_field(plant, kLow, kHigh);
  } catch (const codegen::Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(AffineInputField, OfALinearPlantIsItsBWithoutRounding) {
  const Eigen::MatrixXd b = (Eigen::Matrix2d() << 0.1, -0.3, 1.0 / 3.0, 7e-9).finished();
  const LinearPlant plant("driven", channels({"x1", "x2"}), channels({"y"}), Eigen::Matrix2d::Identity(),
                          Eigen::RowVector2d(1.0, 0.0), channels({"u1", "u2"}), b);
  const codegen::DenseLayer field = affine_input_field(plant, kLow, kHigh);
  EXPECT_EQ(field.weights, Eigen::MatrixXd(Eigen::MatrixXd::Zero(4, 2)));
  EXPECT_EQ(field.bias, Eigen::VectorXd(b.reshaped()));
}

TEST(AffineInputField, OfABilinearPlantIsItsMatricesColumnAfterColumn) {
  const auto plant = driven_by({{"2 + 3*x1", "x2"}, {"-x1 + 4*x2", "5"}});
  const codegen::DenseLayer field = affine_input_field(*plant, kLow, kHigh);
  const Eigen::MatrixXd weights = (Eigen::MatrixXd(4, 2) << 3.0, 0.0, -1.0, 4.0, 0.0, 1.0, 0.0, 0.0).finished();
  constexpr double kRounding = 1e-14;  // of numbers up to 23
  EXPECT_LE((field.weights - weights).cwiseAbs().maxCoeff(), kRounding);
  EXPECT_LE((field.bias - Eigen::Vector4d(2.0, 0.0, 0.0, 5.0)).cwiseAbs().maxCoeff(), kRounding);

  const Eigen::Vector2d x(0.3, 4.0), u(-1.0, 2.0);
  const Eigen::MatrixXd g = (field.weights * x + field.bias).reshaped(2, 2);
  const Eigen::VectorXd sum = -plant->input_field(x, 0) + 2.0 * plant->input_field(x, 1);
  EXPECT_LE((g * u - sum).cwiseAbs().maxCoeff(), 10.0 * kRounding);
}

TEST(AffineInputField, HasTheSlopeAlongAStateThatStartsAtOneValue) {
  const auto plant = driven_by({{"2 + 3*x1"}, {"-x1 + 4*x2"}});
  const codegen::DenseLayer field = affine_input_field(*plant, Eigen::Vector2d(-1.0, 2.0), Eigen::Vector2d(3.0, 2.0));
  const Eigen::Matrix2d weights = (Eigen::Matrix2d() << 3.0, 0.0, -1.0, 4.0).finished();
  EXPECT_LE((field.weights - weights).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_LE((field.bias - Eigen::Vector2d(2.0, 0.0)).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(AffineInputField, NamesTheInputAndTheDeviationOfAFieldThatIsNotAffine) {
  // Odd about the centre x1 = 1: the differences across the box see its chord, not its bend.
  const std::string message = error_of(*driven_by({{"0", "0"}, {"1", "(x1 - 1)^3"}}));
  EXPECT_THAT(message, HasSubstr("plant expressions: the field of input u2 is not affine in the state: at x = ("));
  EXPECT_THAT(message, HasSubstr("it misses the affine fit by 3.08"));  // chord 4 d less d^3: 3.08 at d = 2 / sqrt 3
  EXPECT_THAT(error_of(*driven_by({{"0"}, {"max(x1, 2.5)"}})), HasSubstr("input u1 is not affine"));
  EXPECT_THAT(error_of(*driven_by({{"0"}, {"sqrt(x1)"}})), HasSubstr("input u1 is not affine"));  // NaN below 0
  EXPECT_EQ(error_of(*driven_by({{"0"}, {"x1*1e-3"}})), "no error");
  PlantConfig autonomous;
  autonomous.model = "sine_cosine";
  EXPECT_THAT(error_of(*make_plant(autonomous)), HasSubstr("has no input"));
}

TEST(AffineInputField, OfDerivativesThatNameTheInputsIsTheirSlopeInThemWhereItIsOne) {
  PlantConfig config;
  config.states = {"x1", "x2"};
  config.outputs = {"x1"};
  config.inputs = {"u1", "u2"};
  config.derivative = {"x2 + (2 + 3*x1)*u1 + x2*u2", "-x1 + (-x1 + 4*x2)*u1 + 5*u2"};
  const codegen::DenseLayer named = affine_input_field(*make_plant(config), kLow, kHigh);
  const codegen::DenseLayer field =
      affine_input_field(*driven_by({{"2 + 3*x1", "x2"}, {"-x1 + 4*x2", "5"}}), kLow, kHigh);
  constexpr double kRounding = 1e-13;  // a difference of two derivatives, of numbers up to 40
  EXPECT_LE((named.weights - field.weights).cwiseAbs().maxCoeff(), kRounding);
  EXPECT_LE((named.bias - field.bias).cwiseAbs().maxCoeff(), kRounding);

  for (const char* curved : {"-x1 + u1 + u2^2", "-x1 + u1*u2", "-x1 + u2 + sin(u1)", "-x1 + u2 + sqrt(u1)"}) {
    config.derivative[1] = curved;
    EXPECT_THAT(error_of(*make_plant(config)), HasSubstr("f(x, u) is not affine in its inputs: at x = (")) << curved;
  }
}

}  // namespace
}  // namespace nlo::trainer

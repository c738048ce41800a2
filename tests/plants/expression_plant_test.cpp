// SPDX-License-Identifier: MIT
#include "trainer/plants/expression_plant.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/thrown_message.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;

// Rounding of two orders of evaluation of the same five operations.
constexpr double kRounding = 1e-14;

PlantConfig van_der_pol_by_expressions() {
  PlantConfig config;
  config.states = {"x1", "x2"};
  config.derivative = {"x2", "mu*(1 - x1^2)*x2 - x1"};
  config.outputs = {"x1"};
  config.parameters = {{"mu", 1.7}};
  return config;
}

std::string error_of(const PlantConfig& config) {
  return thrown_message([&] { make_plant(config); });
}

TEST(ExpressionPlant, EqualsTheBuiltInToRounding) {
  PlantConfig builtin;
  builtin.model = "van_der_pol";
  builtin.parameters = {{"mu", 1.7}};
  const auto a = make_plant(builtin), b = make_plant(van_der_pol_by_expressions());
  const Eigen::MatrixXd x = 3.0 * Eigen::MatrixXd::Random(2, 50);
  EXPECT_LE((a->derivative(x) - b->derivative(x)).cwiseAbs().maxCoeff(), kRounding * 30.0);  // terms up to 30
  EXPECT_EQ(a->output(x), b->output(x));
}

PlantConfig driven_by_expressions() {
  PlantConfig config = van_der_pol_by_expressions();
  config.inputs = {"force", "gain"};
  config.input_units = {"N", ""};
  config.input_field = {{"0", "x1*x2"}, {"1", "mu + x1"}};
  return config;
}

TEST(ExpressionPlant, HasTheInputFieldThatItsRowsDescribe) {
  const auto plant = make_plant(driven_by_expressions());
  ASSERT_EQ(plant->nu(), 2);
  EXPECT_EQ(plant->inputs()[0].name, "force");
  EXPECT_EQ(plant->inputs()[0].unit, "N");
  const Eigen::MatrixXd x = Eigen::MatrixXd::Random(2, 20);
  EXPECT_EQ(plant->input_field(x, 0), Eigen::MatrixXd(Eigen::Vector2d(0.0, 1.0).replicate(1, 20)));
  EXPECT_LE((plant->input_field(x, 1).row(0) - x.row(0).cwiseProduct(x.row(1))).cwiseAbs().maxCoeff(), kRounding);
  EXPECT_LE((plant->input_field(x, 1).row(1).array() - 1.7 - x.row(0).array()).abs().maxCoeff(), kRounding);
  EXPECT_EQ(make_plant(van_der_pol_by_expressions())->nu(), 0);
}

TEST(ExpressionPlant, RefusesInputsThatDoNotFit) {
  const auto broken = [](auto&& change) {
    PlantConfig config = driven_by_expressions();
    change(config);
    return error_of(config);
  };
  EXPECT_EQ(broken([](auto&) {}), "no error");
  EXPECT_THAT(broken([](auto& c) { c.inputs.clear(), c.input_units.clear(); }), HasSubstr("give inputs = [\"u\"]"));
  EXPECT_THAT(broken([](auto& c) { c.input_field.pop_back(); }), HasSubstr("input_field has 1 rows, but there are 2"));
  EXPECT_THAT(broken([](auto& c) { c.input_field[1].pop_back(); }), HasSubstr("input_field[1] has 1 expressions"));
  EXPECT_THAT(broken([](auto& c) { c.input_field[1][0] = "x3"; }), HasSubstr("[plant] input_field[1][0] \"x3\""));
  EXPECT_THAT(broken([](auto& c) { c.inputs[0] = "x1"; }), HasSubstr("\"x1\" twice"));
  EXPECT_THAT(broken([](auto& c) { c.inputs[0] = "y"; }), HasSubstr("\"y\" for an input and an output"));
  EXPECT_THAT(broken([](auto& c) { c.input_units.pop_back(); }), HasSubstr("2 inputs but 1 units"));
  EXPECT_THAT(broken([](auto& c) { c.derivative[1] = "-x1 + force"; }), HasSubstr("write inputs in input_field"));
}

/// A cart with a servo and with drag in moving air: neither is affine in its input.
PlantConfig curved_by_expressions() {
  PlantConfig config;
  config.states = {"p", "v"};
  config.derivative = {"v", "k*sin(angle) - (v - wind)*abs(v - wind)"};
  config.outputs = {"p"};
  config.inputs = {"angle", "wind"};
  config.parameters = {{"k", 2.0}};
  return config;
}

TEST(ExpressionPlant, AcceptsAnyFunctionOfStateAndInput) {
  const auto plant = make_plant(curved_by_expressions());
  ASSERT_EQ(plant->nu(), 2);
  EXPECT_FALSE(plant->affine_in_inputs());
  const Eigen::MatrixXd x = Eigen::MatrixXd::Random(2, 30), u = 2.0 * Eigen::MatrixXd::Random(2, 30);
  const auto f = [](const Eigen::Vector2d& at, const Eigen::Vector2d& input) {
    const double air = at(1) - input(1);
    return Eigen::Vector2d(at(1), 2.0 * std::sin(input(0)) - air * std::abs(air));
  };
  const Eigen::MatrixXd driven = plant->driven_derivative(x, u), alone = plant->derivative(x);
  for (Eigen::Index i = 0; i < 30; ++i) {
    EXPECT_LE((driven.col(i) - f(x.col(i), u.col(i))).norm(), 10.0 * kRounding) << "each column has its own u";
    EXPECT_LE((alone.col(i) - f(x.col(i), Eigen::Vector2d::Zero())).norm(), 10.0 * kRounding) << "f(x, 0)";
    const Eigen::Vector2d second = f(x.col(i), Eigen::Vector2d(0.0, 1.0)) - f(x.col(i), Eigen::Vector2d::Zero());
    EXPECT_LE((plant->input_field(x, 1).col(i) - second).norm(), 10.0 * kRounding) << "f(x, e_j) - f(x, 0)";
  }
}

TEST(ExpressionPlant, DerivativeWithInputsEqualsAnInputField) {
  PlantConfig named = driven_by_expressions();
  named.input_field.clear();
  named.derivative = {"x2 + x1*x2*gain", "mu*(1 - x1^2)*x2 - x1 + force + (mu + x1)*gain"};
  const auto a = make_plant(driven_by_expressions()), b = make_plant(named);
  const Eigen::MatrixXd x = Eigen::MatrixXd::Random(2, 20), u = Eigen::MatrixXd::Random(2, 20);
  EXPECT_LE((a->driven_derivative(x, u) - b->driven_derivative(x, u)).cwiseAbs().maxCoeff(), 10.0 * kRounding);
  EXPECT_EQ(a->derivative(x), b->driven_derivative(x, Eigen::MatrixXd::Zero(2, 20)));
}

TEST(ExpressionPlant, RefusesAnInputWithoutEffect) {
  PlantConfig config = curved_by_expressions();
  config.inputs.push_back("idle");
  EXPECT_THAT(error_of(config), HasSubstr("the input \"idle\" has no effect"));
  config = curved_by_expressions();
  config.outputs = {"p + angle"};
  EXPECT_THAT(error_of(config), HasSubstr("an output of a simulated plant is a function of the state alone"));
}

TEST(ExpressionPlant, NamesItsChannels) {
  PlantConfig config = van_der_pol_by_expressions();
  EXPECT_EQ(make_plant(config)->outputs()[0].name, "y");
  config.outputs = {"x1", "x2"};
  EXPECT_EQ(make_plant(config)->outputs()[1].name, "y2");
  config.output_names = {"position", "velocity"};
  config.output_units = {"m", "m/s"};
  EXPECT_EQ(make_plant(config)->outputs()[1].name, "velocity");
  EXPECT_EQ(make_plant(config)->outputs()[1].unit, "m/s");
}

TEST(ExpressionPlant, ReturnsNanOutsideItsDomain) {
  PlantConfig config;
  config.states = {"x1"};
  config.derivative = {"sqrt(x1)"};
  config.outputs = {"1/x1"};
  const auto plant = make_plant(config);
  EXPECT_TRUE(std::isnan(plant->derivative(Eigen::MatrixXd::Constant(1, 1, -1.0))(0, 0)));
  EXPECT_TRUE(std::isinf(plant->output(Eigen::MatrixXd::Zero(1, 1))(0, 0)));
}

TEST(ExpressionPlant, KnowsPiAndComparisons) {
  PlantConfig config;
  config.states = {"x1"};
  config.derivative = {"x1 >= 0 ? cos(pi) : 1"};
  config.outputs = {"x1"};
  const auto plant = make_plant(config);
  EXPECT_EQ(plant->derivative(Eigen::MatrixXd::Constant(1, 1, 2.0))(0, 0), -1.0);
  EXPECT_EQ(plant->derivative(Eigen::MatrixXd::Constant(1, 1, -2.0))(0, 0), 1.0);
}

TEST(ExpressionPlant, ErrorsNameTheExpressionAndThePosition) {
  PlantConfig config = van_der_pol_by_expressions();
  config.derivative[1] = "mu*(1 - x1^2)*x3 - x1";
  EXPECT_THAT(error_of(config), AllOf(HasSubstr("derivative[1]"), HasSubstr("x3"), HasSubstr("position 15")));
  config.derivative[1] = "mu*(1 - x1^2";
  EXPECT_THAT(error_of(config), HasSubstr("derivative[1] \"mu*(1 - x1^2\""));
  config.derivative[1] = "x1 = 2";
  EXPECT_THAT(error_of(config), HasSubstr("an expression cannot contain \"=\""));
  config.derivative[1] = "x1, x2";
  EXPECT_THAT(error_of(config), HasSubstr("2 values"));
  config.derivative[1] = " ";
  EXPECT_THAT(error_of(config), HasSubstr("empty"));
  config.derivative[1] = std::string(5000, '(');
  EXPECT_THAT(error_of(config), HasSubstr("at most 4000 are allowed"));
}

TEST(ExpressionPlant, RefusesCountsAndNamesThatDoNotFit) {
  const auto broken = [](auto&& change) {
    PlantConfig config = van_der_pol_by_expressions();
    change(config);
    return error_of(config);
  };
  EXPECT_THAT(broken([](auto& c) { c.derivative.pop_back(); }), HasSubstr("2 states but 1 derivative"));
  EXPECT_THAT(broken([](auto& c) { c.outputs.clear(); }), HasSubstr("no outputs"));
  EXPECT_THAT(broken([](auto& c) { c.output_names = {"a", "b"}; }), HasSubstr("1 outputs but 2 output_names"));
  EXPECT_THAT(broken([](auto& c) { c.states[1] = "x1"; }), HasSubstr("\"x1\" twice"));
  EXPECT_THAT(broken([](auto& c) { c.parameters[0].first = "x2"; }), HasSubstr("\"x2\" twice"));
  EXPECT_THAT(broken([](auto& c) { c.states[1] = "2x"; }), HasSubstr("not an identifier"));
  EXPECT_THAT(broken([](auto& c) { c.states.clear(); }), HasSubstr("neither a model nor states"));
  EXPECT_THAT(broken([](auto& c) { c.state_units = {"m"}; }), HasSubstr("2 states but 1 units"));
}

}  // namespace
}  // namespace nlo::trainer

// SPDX-License-Identifier: MIT
// Each activation in all tables of codegen. tests/nn/network_activations_test.cpp tests those of the trainer.
#include "codegen/model/activations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlo/jvp.h>

#include <cmath>

#include "codegen/reference/reference_network.h"
#include "codegen/targets/target_registry.h"
#include "tests/codegen/example_models.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {

void PrintTo(const ActivationRow& row, std::ostream* out) {
  *out << row.name;
}

namespace {

using ::testing::HasSubstr;

class EachActivation : public ::testing::TestWithParam<ActivationRow> {
 protected:
  static constexpr double kStep = 1e-5;        // step of central differences
  static constexpr double kDifference = 1e-8;  // their error: kStep^2 times a third derivative of 4 at most
  const ActivationRow& row() const { return GetParam(); }

  /// Calls check(v) over the range of arguments in networks, and beyond.
  template <class Check>
  void over_inputs(const Check& check) const {
    for (double v = -12.0; v <= 12.0; v += 0.01171875) {
      if (row().kink_at_zero && std::abs(v) < 2 * kStep) continue;
      check(v);
    }
  }
};

std::string test_name(const ::testing::TestParamInfo<ActivationRow>& info) {
  return std::string(info.param.name);
}

class EachTrainedActivation : public EachActivation {};

std::vector<ActivationRow> trained_rows() {
  std::vector<ActivationRow> rows;
  for (const ActivationRow& row : kActivations)
    if (row.is_trained()) rows.push_back(row);
  return rows;
}

INSTANTIATE_TEST_SUITE_P(Activations, EachActivation, ::testing::ValuesIn(kActivations), test_name);
INSTANTIATE_TEST_SUITE_P(Activations, EachTrainedActivation, ::testing::ValuesIn(trained_rows()), test_name);

TEST_P(EachActivation, IsFoundOnlyByItsName) {
  EXPECT_EQ(activation_row(row().kind).name, row().name);
  EXPECT_TRUE(activation_row(row().trained_as).is_trained());
  if (row().is_trained()) {
    EXPECT_EQ(activation_named(row().name).kind, row().kind);
    EXPECT_THAT(activation_names(), ::testing::Contains(std::string(row().name)));
  } else {
    EXPECT_EQ(find_activation(row().name), nullptr) << "only an export may choose it";
    EXPECT_THROW(activation_named(row().name), Error);
  }
}

TEST(Activations, RefusesAnUnknownNameAndListsTheKnownOnes) {
  EXPECT_EQ(find_activation("gelu"), nullptr);
  EXPECT_EQ(find_activation(""), nullptr);
  EXPECT_EQ(thrown_message([&] { activation_named("gelu"); }),
            "unknown activation \"gelu\"; use " + activations_in_words());
}

TEST(Activations, ListedNamesAreThoseThatCanBeTrained) {
  std::string words = activations_in_words();
  EXPECT_THAT(words, ::testing::StartsWith("tanh, relu"));
  words.replace(words.find(" or "), 4, ", ");
  std::string names;
  for (const ActivationRow& row : trained_rows()) names += (names.empty() ? "" : ", ") + std::string(row.name);
  EXPECT_EQ(words, names);
}

TEST(Activations, AnUntrainedActivationHasNoTrainingCode) {
  const auto name = [](auto kind) { return activation_row(kind()).name; };
  EXPECT_EQ(with_activation(Activation::kTanh5e6, name), "tanh5e6");
  EXPECT_EQ(with_trained_activation(Activation::kSilu, name), "silu");
  EXPECT_THROW(with_trained_activation(Activation::kTanh5e6, name), Error);
}

TEST_P(EachActivation, ValueAgreesWithTheRuntimeWithinItsAccuracy) {
  with_activation(row().kind, [&](auto kind) {
    over_inputs([&](double v) {
      const double bound = (1.0 + std::abs(v)) * kTanh5e5MaxError;  // the least accurate tanh
      EXPECT_NEAR(static_cast<double>(activate<kind()>(static_cast<float>(v))), row().value(v), bound) << v;
      EXPECT_NEAR(static_cast<double>(activation_slope<kind()>(v, row().value(v))), row().slope(v), bound) << v;
    });
  });
}

TEST_P(EachActivation, SlopeIsTheDerivativeOfTheValue) {
  over_inputs([&](double v) {
    const double difference = (row().value(v + kStep) - row().value(v - kStep)) / (2 * kStep);
    EXPECT_NEAR(row().slope(v), difference, kDifference) << v;
  });
}

TEST_P(EachActivation, CurvatureIsTheDerivativeOfTheSlope) {
  over_inputs([&](double v) {
    const double difference = (row().slope(v + kStep) - row().slope(v - kStep)) / (2 * kStep);
    EXPECT_NEAR(row().curvature(v), difference, kDifference) << v;
  });
}

TEST_P(EachActivation, BoundsHoldAndAreTight) {
  double value = 0.0, curvature = 0.0, change = 0.0;
  over_inputs([&](double v) {
    value = std::max(value, std::abs(row().value(v)));
    curvature = std::max(curvature, std::abs(row().curvature(v)));
    change = std::max(change, std::abs(row().curvature(v + kStep) - row().curvature(v - kStep)) / (2 * kStep));
  });
  EXPECT_LE(curvature, row().largest_curvature);
  EXPECT_GE(curvature, 0.9 * row().largest_curvature);
  EXPECT_LE(change, row().largest_slope_change + kDifference);
  EXPECT_GE(change, 0.6 * row().largest_slope_change);
  if (std::isfinite(row().largest_value)) {
    EXPECT_NEAR(value, row().largest_value, 1e-9);
  } else {
    EXPECT_GE(value, 10.0) << "it is unbounded";
  }
}

/// Over any interval, its ends and the turning points in it enclose all values, and the turning points are reached.
TEST_P(EachActivation, HasTheTurningPointsOfTheTable) {
  const auto expect_enclosed = [&](double (*function)(double), const TurningPoints& turns, const char* what) {
    constexpr double kWithin = 2e-6;  // points are 1.2e-4 apart, and bounds are rounded outwards
    constexpr double kRounding = 1e-15;
    for (const auto& [low, high] : {std::pair{-12.0, 12.0}, {-12.0, -1.0}, {-3.0, 0.5}, {0.5, 12.0}, {2.0, 3.0}}) {
      double least = std::min(function(low), function(high)), most = std::max(function(low), function(high));
      for (const TurningPoint& turn : turns) {
        if (turn.at < low || turn.at > high) continue;
        least = std::min(least, turn.value);
        most = std::max(most, turn.value);
      }
      constexpr int kSteps = 200000;
      double lowest = function(low), highest = lowest;
      for (int i = 1; i <= kSteps; ++i) {
        const double reached = function(low + (high - low) * i / kSteps);
        lowest = std::min(lowest, reached);
        highest = std::max(highest, reached);
      }
      EXPECT_GE(lowest, least - kRounding) << what << " over [" << low << ", " << high << "]";
      EXPECT_LE(highest, most + kRounding) << what << " over [" << low << ", " << high << "]";
      EXPECT_NEAR(lowest, least, kWithin) << what << " over [" << low << ", " << high << "]";
      EXPECT_NEAR(highest, most, kWithin) << what << " over [" << low << ", " << high << "]";
    }
  };
  expect_enclosed(row().value, row().value_turns, "value");
  expect_enclosed(row().slope, row().slope_turns, "slope");
}

template <class Scalar>
void expect_arrays(const ActivationRow& row, double tolerance) {
  const ActivationArray<Scalar> v = Eigen::ArrayX<Scalar>::LinSpaced(997, Scalar(-9), Scalar(9));
  const ActivationArray<Scalar> a = activated<Scalar>(row.kind, v);
  const ActivationArray<Scalar> slopes = activation_slopes<Scalar>(row.kind, v, a);
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    const auto at = static_cast<double>(v(i));
    const double allowed = tolerance * std::max(1.0, std::abs(at));  // SiLU multiplies the error of its function by v
    EXPECT_NEAR(static_cast<double>(a(i)), row.value(at), allowed) << at;
    EXPECT_NEAR(static_cast<double>(slopes(i)), row.slope(at), allowed) << at;
  }
}

TEST_P(EachActivation, ArraysEqualSingleNumbers) {
  expect_arrays<double>(row(), 1e-14);
  expect_arrays<float>(row(), 1e-6);  // Eigen's own tanh and exp
}

TEST_P(EachTrainedActivation, ReferenceNetworkEvaluatesIt) {
  Model model = activation_model(std::string(row().name));
  const Network& network = *inverse_map(model);
  ASSERT_EQ(network.activation, row().kind);
  const Eigen::VectorXd in = Eigen::VectorXd::LinSpaced(network.inputs(), -0.7, 0.9);
  Eigen::VectorXd a = (network.features * in - network.feature_mean).cwiseQuotient(network.feature_scale);
  const Eigen::VectorXd u = a;
  for (std::size_t l = 0; l < network.layers.size(); ++l) {
    a = (network.layers[l].weights * a + network.layers[l].bias).eval();
    if (l + 1 < network.layers.size()) a = a.unaryExpr(row().value).eval();
  }
  if (network.skip.size() != 0) a += network.skip * u;
  a = (a.cwiseProduct(network.output_scale) + network.output_mean).eval();
  EXPECT_LE((ReferenceNetwork<double>(network)(in) - a).cwiseAbs().maxCoeff(), 1e-13);
  const ReferenceNetwork<double> flown(network, nlo::codegen::Activations::kRuntime);
  EXPECT_LE((flown(in) - a).cwiseAbs().maxCoeff(), 1e-12);
}

/// All files of an export as one text.
std::string exported(const Model& model, const std::string& target, ScalarType scalar) {
  ExportOptions options;
  options.scalar = scalar;
  std::string text;
  for (const NamedText& file : export_target(target).generate(PreparedExport(model, options))) text += file.text;
  return text;
}

TEST_P(EachTrainedActivation, HeadersNameIt) {
  const Model model = activation_model(std::string(row().name));
  for (const ScalarType scalar : {ScalarType::kFloat, ScalarType::kDouble})
    EXPECT_THAT(exported(model, "cpp", scalar), HasSubstr("make_mlp<" + std::string(row().identifier) + ">"));
}

TEST_P(EachTrainedActivation, C99HasItsFunctionOrRefusesItByName) {
  const Model model = activation_model(std::string(row().name));
  for (const ScalarType scalar : {ScalarType::kFloat, ScalarType::kDouble}) {
    if (row().has_c99) {
      const std::string function = row().name == "tanh" ? "tanh_rational" : std::string(row().name);
      EXPECT_THAT(exported(model, "c99", scalar), testing::AllOf(HasSubstr("static Scalar " + function + "(Scalar"),
                                                                 HasSubstr("out[o] = " + function + "(out[o]);")));
    } else {
      EXPECT_THROW(exported(model, "c99", scalar), Error);
    }
  }
}

TEST_P(EachTrainedActivation, Int16HasItOrRefusesItByName) {
  const Model model = activation_model(std::string(row().name));
  for (const char* target : {"cpp", "c99"}) {
    if (row().has_int16()) {
      EXPECT_NE(exported(model, target, ScalarType::kInt16), "");
      continue;
    }
    EXPECT_THAT(thrown_message([&] { exported(model, target, ScalarType::kInt16); }),
                HasSubstr(std::string(row().name)));
  }
}

}  // namespace
}  // namespace nlo::codegen

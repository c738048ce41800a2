// SPDX-License-Identifier: MIT
// Weights of 16 bits and the choice of a tanh in exports.
#include "codegen/targets/number_formats.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlo/kernels/weight.h>
#include <nlo/mlp.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/replay/export_error.h"
#include "codegen/replay/replay_run.h"
#include "codegen/targets/c99.h"
#include "codegen/targets/cpp_header.h"
#include "codegen/targets/golden_replay.h"
#include "codegen/targets/library.h"
#include "tests/codegen/example_models.h"
#include "tests/codegen/golden.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {
namespace {

using testing::HasSubstr;
using testing::Not;

ExportOptions with_weights(WeightType weights) {
  ExportOptions options;
  options.weights = weights;
  return options;
}

double error_with(const PreparedExport& plain, const ExportOptions& options) {
  return plain.with(options).error().max.maxCoeff();
}

TEST(Rounded, EqualsTheRoundingOfTheRuntimeForEveryFloat) {
  std::mt19937 random(1);
  for (int k = 0; k < 1000000; ++k) {
    const auto single = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (!std::isfinite(single)) continue;
    const double value = static_cast<double>(single);
    ASSERT_EQ(rounded(value, WeightType::kBfloat16), static_cast<double>(static_cast<float>(Bfloat16(single))))
        << value;
    const double fp16 = rounded(value, WeightType::kFloat16);
    const Float16 half(single);
    ASSERT_EQ(std::isinf(fp16), (half.bits & 0x7fffU) == 0x7c00U) << value;
    if (std::isinf(fp16)) continue;
    ASSERT_EQ(fp16, static_cast<double>(static_cast<float>(half))) << value;
  }
}

TEST(Rounded, RoundsDirectlyFromDouble) {
  const double bf16 = 1.0 + 0x1p-8 + 0x1p-40, fp16 = 1.0 + 0x1p-11 + 0x1p-40;  // slightly above a tie
  EXPECT_EQ(rounded(bf16, WeightType::kBfloat16), 1.0 + 0x1p-7);
  EXPECT_EQ(rounded(fp16, WeightType::kFloat16), 1.0 + 0x1p-10);
  EXPECT_EQ(rounded(1.0 + 0x1p-11, WeightType::kFloat16), 1.0);  // the tie: to even
  EXPECT_EQ(rounded(0x1p-25, WeightType::kFloat16), 0.0);
  EXPECT_EQ(rounded(0x1.8p-25, WeightType::kFloat16), 0x1p-24);
  EXPECT_EQ(rounded(65519.9, WeightType::kFloat16), 65504.0);
  EXPECT_EQ(rounded(-65520.0, WeightType::kFloat16), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(rounded(0.1, WeightType::kFull), 0.1);
}

TEST(HalfWeights, EqualTheirGoldenFile) {
  expect_golden(cpp_header(PreparedExport(tiny_model(), with_weights(WeightType::kBfloat16))), "tiny_bf16.h");
}

TEST(HalfWeights, CauseAnErrorOfTheOrderOfTheirRounding) {
  // Relative rounding 2^-9 and 2^-12 over a few layers; a replay in float differs by 1e-6.
  for (const Model& m : {paper_model(), rig_model(), luenberger_model(), general_model(), driven_model()}) {
    const double largest = run_replay(PreparedExport(m)).x_hat.cwiseAbs().maxCoeff();
    const PreparedExport plain(m);
    const double bf16 = error_with(plain, with_weights(WeightType::kBfloat16)) / largest;
    const double fp16 = error_with(plain, with_weights(WeightType::kFloat16)) / largest;
    EXPECT_LT(bf16, 8 * 0x1p-9) << m.name;
    EXPECT_LT(fp16, 8 * 0x1p-12) << m.name;
    EXPECT_LT(fp16, bf16) << m.name;
    EXPECT_GT(fp16, 3 * error_with(plain, {}) / largest) << m.name;
  }
}

TEST(HalfWeights, KeepBiasesAndLinearPathsInFloat) {
  const FoldedNetwork whole = *fold(rig_model()).inverse_map();
  const FoldedNetwork half = *in_formats(fold(rig_model()), with_weights(WeightType::kFloat16)).inverse_map();
  EXPECT_EQ(half.linear_path, whole.linear_path);
  for (std::size_t l = 0; l < whole.layers.size(); ++l) {
    EXPECT_EQ(half.layers[l].bias, whole.layers[l].bias);
    EXPECT_NE(half.layers[l].weights, whole.layers[l].weights);
  }
}

std::string refusal_of(const Model& model, const ExportOptions& options,
                       std::string (*text)(const PreparedExport&) = cpp_header) {
  return thrown_message([&] { text(PreparedExport(model, options)); });
}

TEST(HalfWeights, ErrorsBeyondTheirRangeNameTheLayerAndTheRemedy) {
  Model m = tiny_model();
  inverse_map(m)->layers[1].weights(0, 2) = 1e5;
  for (const auto text : {cpp_header, replay})
    EXPECT_THAT(refusal_of(m, with_weights(WeightType::kFloat16), text),
                testing::AllOf(HasSubstr("inverse_map.layers[1].weights"), HasSubstr("fp16"), HasSubstr("bf16")));
  EXPECT_EQ(refusal_of(m, with_weights(WeightType::kBfloat16)), "no error");
}

TEST(HalfWeights, AreForFloatAndForTheCppTargets) {
  for (const ScalarType scalar : {ScalarType::kDouble, ScalarType::kInt16}) {
    ExportOptions options = with_weights(WeightType::kBfloat16);
    options.scalar = scalar;
    EXPECT_THAT(refusal_of(tiny_model(), options), HasSubstr("needs --scalar float"));
  }
  const ExportOptions options = with_weights(WeightType::kFloat16);
  EXPECT_THROW(c99(PreparedExport(tiny_model(), options)), Error);
  EXPECT_THROW(replay_c99(PreparedExport(tiny_model(), options)), Error);
  EXPECT_THROW(arduino_library(PreparedExport(tiny_model(), options)), Error);
  EXPECT_THROW(zephyr_module(PreparedExport(tiny_model(), options)), Error);
  EXPECT_THROW(weight_type("half"), Error);
}

TEST(CheapestTanh, IsTheCheapestWhoseMeasuredErrorIsWithinTheLimit) {
  for (const Model& m : {paper_model(), general_model(), driven_model()}) {
    const PreparedExport plain(m);
    std::vector<double> errors;
    for (const TanhTier& tier : kTanhTiers) {
      ExportOptions options;
      options.tanh = tier.kind;
      errors.push_back(error_with(plain, options));
    }
    ASSERT_GT(errors[0], 2.0 * errors[1]) << m.name;
    const auto chosen = [&m](double limit) { return PreparedExport(m, {}, fmt::format("{}", limit)).options().tanh; };
    EXPECT_EQ(chosen(1.01 * errors[0]), Activation::kTanh5e5) << m.name;
    EXPECT_EQ(chosen(0.99 * errors[0]), Activation::kTanh5e6) << m.name;
    EXPECT_EQ(chosen(0.5 * std::min(errors[1], errors[2])), Activation::kTanh) << m.name;
  }
}

TEST(CheapestTanh, IsTheSameInEveryTargetAndStatesTheReason) {
  const Model m = activation_model("tanh");
  const ExportOptions options = PreparedExport(m, {}, "x1=1,x2=1").options();
  const std::string header = cpp_header(PreparedExport(m, options));
  EXPECT_THAT(header, HasSubstr("make_mlp<Activation::kTanh5e5>"));
  EXPECT_THAT(header, HasSubstr("// tanh within 5e-05 (Activation::kTanh5e5): the cheapest that is within --max-error "
                                "x1=1,x2=1.\n"));
  EXPECT_THAT(header, HasSubstr("nlo export model.json --max-error x1=1,x2=1 -o"));
  EXPECT_THAT(replay(PreparedExport(m, options)), HasSubstr("--target replay --max-error x1=1,x2=1 -o"));
  EXPECT_NE(replay(PreparedExport(m, options)), replay(PreparedExport(m, {})))
      << "its tolerances are those of that tanh";
  for (const NamedText& file : arduino_library(PreparedExport(m, options))) {
    if (file.path == "src/tiny_tanh.h") {
      EXPECT_THAT(file.text, HasSubstr("make_mlp<Activation::kTanh5e5>"));
    }
    if (file.path.ends_with(".c")) {
      EXPECT_EQ(file.text, c99(PreparedExport(m, {.name = "tiny_tanh_c99"}))[1].text);
    }
  }
  EXPECT_EQ(replay_c99(PreparedExport(m, options)), replay_c99(PreparedExport(m, {})))
      << "C99 always uses the most accurate tanh";
}

TEST(CheapestTanh, StaysUnchangedWithoutAChoice) {
  ExportOptions in_double;
  in_double.scalar = ScalarType::kDouble;
  EXPECT_EQ(PreparedExport(tiny_model(), in_double, "1").options().tanh, Activation::kTanh);
  for (const Model& m : {activation_model("relu"), activation_model("silu"), linear_model()})
    EXPECT_EQ(cpp_header(PreparedExport(m, {}, "1")), cpp_header(PreparedExport(m))) << m.name;
  EXPECT_THAT(cpp_header(PreparedExport(tiny_model(), {})), HasSubstr("make_mlp<Activation::kTanh>"));
}

TEST(LargeNetworks, AreWrittenInMemoryLayout) {
  EXPECT_THAT(cpp_header(PreparedExport(paper_model(), {})), Not(HasSubstr("PanelDense")));
  const std::string header = cpp_header(PreparedExport(mixed_model(), {}));
  for (const char* layer : {"constexpr Dense<float, 3, 18>", "constexpr PanelDense<float, 18, 300>",
                            "constexpr PanelDense<float, 300, 60>", "constexpr Dense<float, 60, 2>"})
    EXPECT_THAT(header, HasSubstr(layer));
}

TEST(LargeNetworks, HaveTheLayoutOfTheRuntime) {
  constexpr int kIn = 18, kOut = 300;
  using Panels = PanelDense<float, kIn, kOut>;
  const Eigen::MatrixXd weights = fold(mixed_model()).inverse_map()->layers[1].weights;
  static Dense<float, kIn, kOut> layer;
  for (int o = 0; o < kOut; ++o)
    for (int i = 0; i < kIn; ++i) layer.weights[o][i] = static_cast<float>(weights(o, i));
  if constexpr (std::is_same_v<decltype(pack(layer)), Panels>) {  // this machine has vectors
    const Panels packed = pack(layer);
    const std::string header = cpp_header(PreparedExport(mixed_model(), {}));
    std::size_t at = header.find("{", header.find(".weights = ", header.find("kLayer2 = "))) + 1;
    for (const float weight : packed.weights) {
      std::size_t length = 0;
      ASSERT_EQ(std::stof(header.substr(at, 40), &length), weight);
      at += length + 2;  // "f,"
    }
    EXPECT_EQ(header.substr(at, 8), "\n    },\n");
  }
}

}  // namespace
}  // namespace nlo::codegen

// SPDX-License-Identifier: MIT
#include "codegen/targets/number_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "codegen/base/error.h"
#include "codegen/model/activations.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {
namespace {

/// A binary format. Numbers are whole multiples of 2^(exponent - bits); subnormal numbers are multiples of 2^lowest.
struct Format {
  int bits, lowest;
  double largest;
};
constexpr Format kBfloat16Format{8, -133, 0x1.FEp127}, kFloat16Format{11, -24, 65504.0};

void round_weights(FoldedNetwork& network, WeightType type) {
  for (std::size_t l = 0; l < network.layers.size(); ++l) {
    for (double& weight : network.layers[l].weights.reshaped()) {
      const double nearest = rounded(weight, type);
      if (std::isinf(nearest))
        throw Error(
            fmt::format("{}.layers[{}].weights has {:.4g} when folded, which exceeds the range of {}; export with "
                        "--weights {}, or train again with weight_decay",
                        network.field, l, weight, weight_name(type), type == WeightType::kFloat16 ? "bf16" : "float"));
      weight = nearest;
    }
  }
}

}  // namespace

bool has_tanh(const FoldedModel& folded) {
  return std::any_of(folded.networks.begin(), folded.networks.end(), [](const FoldedNetwork& n) {
    return n.layers.size() > 1 && activation_row(n.activation).trained_as == Activation::kTanh;
  });
}

double rounded(double value, WeightType type) {
  if (type == WeightType::kFull || value == 0.0 || !std::isfinite(value)) return value;
  const Format& format = type == WeightType::kBfloat16 ? kBfloat16Format : kFloat16Format;
  const int unit = std::max(std::ilogb(value) + 1 - format.bits, format.lowest);
  // nearbyint takes ties to even, and scaling by powers of two is exact down to 2^-1074.
  const double nearest = std::ldexp(std::nearbyint(std::ldexp(value, -unit)), unit);
  return std::abs(nearest) <= format.largest ? nearest : std::copysign(std::numeric_limits<double>::infinity(), value);
}

FoldedModel in_formats(FoldedModel folded, const ExportOptions& options) {
  const bool is_float = options.scalar == ScalarType::kFloat;
  if (options.weights != WeightType::kFull && !is_float)
    throw Error(fmt::format("--weights {} needs --scalar float, but the scalar is {}; leave one of them out",
                            weight_name(options.weights), scalar_name(options.scalar)));
  if (options.scalar == ScalarType::kInt16) folded.error.reset();  // its hidden layers are integers
  for (FoldedNetwork& network : folded.networks) {
    if (options.weights != WeightType::kFull) round_weights(network, options.weights);
    if (network.activation == Activation::kTanh && is_float) network.activation = options.tanh;
  }
  return folded;
}

void check_weights(const ExportOptions& options, std::string_view target) {
  if (options.weights != WeightType::kFull)
    throw Error(fmt::format("--weights {} is only for targets cpp and replay; leave it out of --target {}",
                            weight_name(options.weights), target));
}

std::string tanh_note(const ExportOptions& options) {
  if (options.max_error.empty()) return "";
  const auto tier =
      std::find_if(kTanhTiers.begin(), kTanhTiers.end(), [&](const TanhTier& t) { return t.kind == options.tanh; });
  return fmt::format("tanh within {:.0e} ({}): {} --max-error {}", tier->max_error,
                     activation_row(options.tanh).identifier,
                     options.tanh == Activation::kTanh ? "a coarser one is beyond" : "the cheapest that is within",
                     safe_comment(options.max_error, 60));
}

std::string number_flags(const ExportOptions& options) {
  std::string flags;
  if (options.scalar != ScalarType::kFloat) flags += fmt::format(" --scalar {}", scalar_name(options.scalar));
  if (options.weights != WeightType::kFull) flags += fmt::format(" --weights {}", weight_name(options.weights));
  if (!options.max_error.empty()) flags += fmt::format(" --max-error {}", safe_comment(options.max_error, 200));
  return flags;
}

std::string numbers_name(const ExportOptions& options) {
  const std::string scalar = scalar_name(options.scalar);
  return options.weights == WeightType::kFull ? scalar : scalar + " with weights in " + weight_name(options.weights);
}

}  // namespace nlo::codegen

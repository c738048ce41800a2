// SPDX-License-Identifier: MIT
#include "codegen/number_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "codegen/error.h"
#include "codegen/error_limits.h"
#include "codegen/targets/generated_text.h"

namespace nlo::codegen {
namespace {

/// A binary format: numbers are whole multiples of 2^(exponent - bits), and of 2^lowest where they are subnormal.
struct Format {
  int bits, lowest;
  double largest;
};
constexpr Format kBfloat16Format{8, -133, 0x1.FEp127}, kFloat16Format{11, -24, 65504.0};

void round_weights(FoldedNetwork& network, WeightType type, const char* field) {
  for (std::size_t l = 0; l < network.layers.size(); ++l) {
    for (double& weight : network.layers[l].weights.reshaped()) {
      const double nearest = rounded(weight, type);
      if (std::isinf(nearest))
        throw Error(
            fmt::format("{}.layers[{}].weights has {:.4g} when folded: beyond the range of {}; export with "
                        "--weights {}, or train again with weight_decay",
                        field, l, weight, weight_name(type), type == WeightType::kFloat16 ? "bf16" : "float"));
      weight = nearest;
    }
  }
}

/// A hidden layer of the model goes through tanh.
bool has_tanh(const FoldedModel& folded) {
  const auto uses = [](const FoldedNetwork& n) { return n.layers.size() > 1 && n.activation == "tanh"; };
  return uses(folded.inverse_map) || uses(folded.forward_map) || uses(folded.nonlinearity) || uses(folded.dynamics);
}

}  // namespace

const TanhTier& tanh_tier(Activation kind) {
  return *std::find_if(kTanhTiers.begin(), kTanhTiers.end() - 1, [&](const TanhTier& t) { return t.kind == kind; });
}

double rounded(double value, WeightType type) {
  if (type == WeightType::kFull || value == 0.0 || !std::isfinite(value)) return value;
  const Format& format = type == WeightType::kBfloat16 ? kBfloat16Format : kFloat16Format;
  const int unit = std::max(std::ilogb(value) + 1 - format.bits, format.lowest);
  // nearbyint takes ties to even, and scaling by powers of two is exact down to 2^-1074.
  const double nearest = std::ldexp(std::nearbyint(std::ldexp(value, -unit)), unit);
  return std::abs(nearest) <= format.largest ? nearest : std::copysign(std::numeric_limits<double>::infinity(), value);
}

FoldedModel fold(const Model& model, const ExportOptions& options) {
  FoldedModel folded = fold(model);
  const bool is_float = options.scalar == ScalarType::kFloat;
  if (options.weights != WeightType::kFull && !is_float)
    throw Error(fmt::format("--weights {} is for --scalar float, and this is {}; leave one of them out",
                            weight_name(options.weights), scalar_name(options.scalar)));
  for (const auto& [network, field] : {std::pair{&folded.inverse_map, "inverse_map"},
                                       {&folded.forward_map, "drive.forward_map"},
                                       {&folded.nonlinearity, "luenberger.nonlinearity"},
                                       {&folded.dynamics, "dynamics"}}) {
    if (options.weights != WeightType::kFull) round_weights(*network, options.weights, field);
    if (network->activation == "tanh" && is_float) network->activation = tanh_tier(options.tanh).name;
  }
  return folded;
}

void check_weights(const ExportOptions& options, std::string_view target) {
  if (options.weights != WeightType::kFull)
    throw Error(fmt::format("--weights {} is for targets cpp and replay; leave it out of --target {}",
                            weight_name(options.weights), target));
}

ExportOptions with_cheapest_tanh(const Model& model, const ExportOptions& options, const std::string& max_error) {
  const Eigen::VectorXd limits = error_limits(max_error, model);
  if (options.scalar != ScalarType::kFloat || !has_tanh(fold(model))) return options;
  ExportOptions chosen = options;
  chosen.max_error = max_error;
  const ErrorReplay replay(model);
  for (const TanhTier& tier : kTanhTiers) {
    chosen.tanh = tier.kind;
    if (tier.kind == Activation::kTanh) break;
    if ((replay.error(chosen).max.array() <= limits.array()).all()) break;
  }
  return chosen;
}

std::string tanh_note(const ExportOptions& options) {
  if (options.max_error.empty()) return "";
  const TanhTier& tier = tanh_tier(options.tanh);
  return fmt::format("tanh within {:.0e} ({}): {} --max-error {}", tier.max_error, tier.identifier,
                     tier.kind == Activation::kTanh ? "a coarser one is beyond" : "the cheapest that is within",
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

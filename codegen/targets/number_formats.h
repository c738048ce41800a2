// SPDX-License-Identifier: MIT
// Cheaper numbers than the scalar of an export: weights of 16 bits (nlo/kernels/weight.h), and a tanh that is only as
// accurate as the allowed error requires (nlo/kernels/activation.h).
#pragma once

#include <nlo/kernels/activation.h>
#include <Eigen/Core>
#include <array>
#include <string>
#include <string_view>

#include "codegen/fold/fold.h"
#include "codegen/text/export_options.h"

namespace nlo::codegen {

/// A tanh of the runtime, with its largest error.
struct TanhTier {
  Activation kind;
  double max_error;
};

/// The cheapest comes first.
inline constexpr std::array kTanhTiers = {TanhTier{Activation::kTanh5e5, kTanh5e5MaxError},
                                          TanhTier{Activation::kTanh5e6, kTanh5e6MaxError},
                                          TanhTier{Activation::kTanh, kTanhMaxError}};

/// Returns true if a hidden layer of the model has tanh.
bool has_tanh(const FoldedModel& folded);

/// Returns `folded` in the numbers of `options`: weights of layers rounded to 16 bits, and the chosen tanh. A header
/// contains these numbers, and the emulation in replay_run.h uses them. Throws Error with the layer and the remedy if a
/// weight overflows, or if the scalar does not support 16 bits.
FoldedModel in_formats(FoldedModel folded, const ExportOptions& options);

/// Returns the nearest number in 16 bits, ties to even. It rounds directly from double, because rounding to float first
/// could round twice. Returns infinity beyond the largest number, and a float unchanged.
double rounded(double value, WeightType type);

/// Throws Error if `options` ask for weights that `target` does not support.
void check_weights(const ExportOptions& options, std::string_view target);

/// Returns "tanh within 5e-06 (Activation::kTanh5e6): the cheapest that --max-error 0.01 allows"; empty if none was
/// chosen.
std::string tanh_note(const ExportOptions& options);

/// Returns the command-line options that give these numbers: " --scalar double --weights bf16 --max-error 0.01".
std::string number_flags(const ExportOptions& options);

/// Returns "float", "int16" or "float with weights in bf16".
std::string numbers_name(const ExportOptions& options);

}  // namespace nlo::codegen

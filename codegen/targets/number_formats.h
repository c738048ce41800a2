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

/// One tanh of the runtime.
struct TanhTier {
  Activation kind;
  double max_error;
};

/// Cheapest first.
inline constexpr std::array kTanhTiers = {TanhTier{Activation::kTanh5e5, kTanh5e5MaxError},
                                          TanhTier{Activation::kTanh5e6, kTanh5e6MaxError},
                                          TanhTier{Activation::kTanh, kTanhMaxError}};

/// A hidden layer of the model goes through tanh.
bool has_tanh(const FoldedModel& folded);

/// `folded` in the numbers of `options`: weights of layers rounded to 16 bits, the tanh that was chosen. A header
/// writes these numbers and the emulation in replay_run.h runs them. Throws Error, naming the layer and the mend, when
/// a weight overflows, or when the scalar does not go with 16 bits.
FoldedModel in_formats(FoldedModel folded, const ExportOptions& options);

/// The nearest number that 16 bits hold, ties to even: from double at once, for by way of float it could be rounded
/// twice. Infinity beyond the largest; a float comes as it is.
double rounded(double value, WeightType type);

/// Throws Error when `options` ask for weights that `target` does not write.
void check_weights(const ExportOptions& options, std::string_view target);

/// "tanh within 5e-06 (Activation::kTanh5e6): the cheapest that --max-error 0.01 allows"; empty when nothing was
/// chosen.
std::string tanh_note(const ExportOptions& options);

/// " --scalar double --weights bf16 --max-error 0.01": the options of the command line that give these numbers.
std::string number_flags(const ExportOptions& options);

/// "float", "int16", "float with weights in bf16".
std::string numbers_name(const ExportOptions& options);

}  // namespace nlo::codegen

// SPDX-License-Identifier: MIT
// Options of an export: its name and its number formats.
#pragma once

#include <nlo/kernels/activation.h>
#include <cstdint>
#include <string>

namespace nlo::codegen {

enum class ScalarType {
  kFloat,
  kDouble,
  kInt16,  ///< the inverse map in int16 (codegen/fold/quantise.h), everything else in float
};

/// Storage format of the weights of layers. Biases and linear paths have the type of the scalar.
enum class WeightType : std::uint8_t {
  kFull,      ///< "float" on the command line: the type of the scalar
  kBfloat16,  ///< "bf16"
  kFloat16,   ///< "fp16"
};

struct ExportOptions {
  std::string name;  ///< namespace and file name of the export; empty: the model's own
  ScalarType scalar = ScalarType::kFloat;
  WeightType weights = WeightType::kFull;
  Activation tanh = Activation::kTanh;  ///< one of the runtime's three tanh; PreparedExport sets this and max_error
  std::string max_error = {};           ///< limit of error for which tanh was chosen; empty: none
  std::string roles = {};  ///< simplefoc: channels of the roles, "angle=theta,velocity=omega"; empty: found by unit
  std::uint64_t seed = 1;  ///< replay: seed of the golden inputs
  int samples = 400;       ///< replay: number of samples
};

/// Returns `options` with the most accurate tanh, the only one that C99 has.
ExportOptions best_tanh(ExportOptions options);

/// Reads "float", "double" or "int16". Throws Error for other names.
ScalarType scalar_type(const std::string& name);
const char* scalar_name(ScalarType scalar);

/// Reads "float", "bf16" or "fp16". Throws Error for other names.
WeightType weight_type(const std::string& name);
const char* weight_name(WeightType type);

}  // namespace nlo::codegen

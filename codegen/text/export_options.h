// SPDX-License-Identifier: MIT
// How a model is exported: under which name, in which numbers.
#pragma once

#include <nlo/kernels/activation.h>
#include <cstdint>
#include <string>

namespace nlo::codegen {

enum class ScalarType {
  kFloat,
  kDouble,
  kInt16,  ///< the inverse map in int16 (codegen/fold/quantise.h), all around it in float
};

/// How the weights of layers are stored; biases and linear paths are of the scalar.
enum class WeightType : std::uint8_t {
  kFull,      ///< "float": as the scalar
  kBfloat16,  ///< "bf16"
  kFloat16,   ///< "fp16"
};

struct ExportOptions {
  std::string name;  ///< namespace and file name of the export; empty: the model's own
  ScalarType scalar = ScalarType::kFloat;
  WeightType weights = WeightType::kFull;
  Activation tanh = Activation::kTanh;  ///< one of the runtime's three tanh; PreparedExport sets this and max_error
  std::string max_error = {};           ///< the limit by which tanh was chosen; empty: it was not
  std::string roles = {};               ///< simplefoc: its channels, "angle=theta,velocity=omega"; empty: by unit
  std::uint64_t seed = 1;               ///< replay: of the golden inputs
  int samples = 400;                    ///< replay: how many
};

/// `options` with the most accurate tanh: C99 has no other.
ExportOptions best_tanh(ExportOptions options);

/// "float", "double" or "int16". Throws Error.
ScalarType scalar_type(const std::string& name);
const char* scalar_name(ScalarType scalar);

/// "float", "bf16" or "fp16". Throws Error.
WeightType weight_type(const std::string& name);
const char* weight_name(WeightType type);

}  // namespace nlo::codegen

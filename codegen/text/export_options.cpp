// SPDX-License-Identifier: MIT
#include "codegen/text/export_options.h"

#include "codegen/base/error.h"

namespace nlo::codegen {

ExportOptions best_tanh(ExportOptions options) {
  options.tanh = Activation::kTanh;
  options.max_error = "";
  return options;
}

ScalarType scalar_type(const std::string& name) {
  for (const ScalarType scalar : {ScalarType::kFloat, ScalarType::kDouble, ScalarType::kInt16})
    if (name == scalar_name(scalar)) return scalar;
  throw Error("unknown scalar type \"" + name + "\"; there are float, double, int16");
}

const char* scalar_name(ScalarType scalar) {
  return scalar == ScalarType::kFloat ? "float" : scalar == ScalarType::kDouble ? "double" : "int16";
}

WeightType weight_type(const std::string& name) {
  for (const WeightType type : {WeightType::kFull, WeightType::kBfloat16, WeightType::kFloat16})
    if (name == weight_name(type)) return type;
  throw Error("unknown type of weights \"" + name + "\"; there are float, bf16, fp16");
}

const char* weight_name(WeightType type) {
  return type == WeightType::kFull ? "float" : type == WeightType::kBfloat16 ? "bf16" : "fp16";
}

}  // namespace nlo::codegen

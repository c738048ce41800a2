// SPDX-License-Identifier: MIT
// What a model can be exported to. A new target is one file beside this one and one line in registry.cpp.
#pragma once

#include <nlo/activation.h>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "codegen/file.h"
#include "codegen/model.h"

namespace nlo::codegen {

enum class ScalarType {
  kFloat,
  kDouble,
  kInt16,  ///< the inverse map in int16 (codegen/quantise.h), all around it in float
};

/// How the weights of layers are stored; biases and linear paths are of the scalar.
enum class WeightType : std::uint8_t {
  kFull,      ///< "float": as the scalar
  kBfloat16,  ///< "bf16"
  kFloat16,   ///< "fp16"
};

struct ExportOptions {
  std::string name;  ///< namespace and file name of what is generated; empty: the model's own
  ScalarType scalar = ScalarType::kFloat;
  WeightType weights = WeightType::kFull;
  Activation tanh = Activation::kTanh;  ///< of the runtime's three; with_cheapest_tanh() sets both of these
  std::string max_error = {};           ///< the limit by which tanh was chosen; empty: it was not
  std::uint64_t seed = 1;               ///< replay: of the golden inputs
  int samples = 400;                    ///< replay: how many
};

/// What an export is made of.
enum class ExportForm : std::uint8_t {
  kFile,       ///< one file, under any name
  kFiles,      ///< several that include each other by name, in one folder; the first is the one to include
  kDirectory,  ///< a folder of its own
};

struct ExportTarget {
  std::string name;         ///< on the command line
  std::string description;  ///< one line of help
  ExportForm form;
  /// The files, their paths relative to where the export goes. Throws Error.
  std::function<std::vector<NamedText>(const Model&, const ExportOptions&)> generate;
};

const std::vector<ExportTarget>& export_targets();

/// The target of that name. Throws Error that lists the names there are.
const ExportTarget& export_target(const std::string& name);

/// "float", "double" or "int16". Throws Error.
ScalarType scalar_type(const std::string& name);
const char* scalar_name(ScalarType scalar);

/// "float", "bf16" or "fp16". Throws Error.
WeightType weight_type(const std::string& name);
const char* weight_name(WeightType type);

}  // namespace nlo::codegen

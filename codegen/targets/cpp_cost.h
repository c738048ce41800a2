// SPDX-License-Identifier: MIT
// What an observer in a generated C++ header costs, as far as the model alone decides it.
#pragma once

#include <Eigen/Core>

#include "codegen/model/model.h"
#include "codegen/targets/prepared_export.h"
#include "codegen/text/cpp_structure.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

struct CppCost {
  Eigen::Index step_multiply_adds = 0, step_activations = 0;
  Eigen::Index estimate_multiply_adds = 0, estimate_activations = 0;
  Eigen::Index constant_bytes = 0;  ///< sizeof(Model)
  Eigen::Index observer_bytes = 0;  ///< sizeof(Observer) where pointers have 32 bits

  Eigen::Index multiply_adds() const { return step_multiply_adds + estimate_multiply_adds; }
};
CppCost cpp_cost(const Model& model, const CppStructure& structure, const Initialiser& init);
CppCost cpp_cost(const PreparedExport& prepared);

}  // namespace nlo::codegen

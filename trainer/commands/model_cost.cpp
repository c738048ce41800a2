// SPDX-License-Identifier: MIT
#include "trainer/commands/model_cost.h"

#include "codegen/export/cpp_cost.h"
#include "codegen/export/prepared_export.h"
#include "codegen/structures/module.h"

namespace nlo::trainer {

JobCost model_cost(const codegen::Model& model) {
  const codegen::PreparedExport prepared(model);
  const codegen::CppCost cost =
      cpp_cost(model, *codegen::module_of(model).cpp(prepared.source()), prepared.initialiser());
  return {cost.step_multiply_adds + cost.estimate_multiply_adds, cost.constant_bytes};
}

}  // namespace nlo::trainer

// SPDX-License-Identifier: MIT
#include "trainer/app/commands/model_cost.h"

#include "codegen/targets/cpp_cost.h"

namespace nlo::trainer {

JobCost model_cost(const codegen::Model& model) {
  const codegen::CppCost cost = cpp_cost(codegen::PreparedExport(model));
  return {cost.multiply_adds(), cost.constant_bytes};
}

}  // namespace nlo::trainer

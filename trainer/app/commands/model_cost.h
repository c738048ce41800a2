// SPDX-License-Identifier: MIT
// The cost of an observer as a C++ header in float.
#pragma once

#include "codegen/model/model.h"
#include "trainer/app/sweep/results.h"

namespace nlo::trainer {

JobCost model_cost(const codegen::Model& model);

}  // namespace nlo::trainer

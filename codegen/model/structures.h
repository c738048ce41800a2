// SPDX-License-Identifier: MIT
// The structures that a model can have. A new one needs a line here, a line in structure_modules.cpp, and its module.
#pragma once

#include <variant>

#include "codegen/model/carried.h"
#include "codegen/model/driven_kkl.h"
#include "codegen/model/gated.h"
#include "codegen/model/general.h"
#include "codegen/model/kkl.h"
#include "codegen/model/luenberger.h"
#include "codegen/model/prior.h"

namespace nlo::codegen {

using Structure = std::variant<Kkl, DrivenKkl, Luenberger, General, Gated, Carried, Prior>;

}  // namespace nlo::codegen

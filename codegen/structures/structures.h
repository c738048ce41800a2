// SPDX-License-Identifier: MIT
// The structures that a model can have. One more is a line here, a line in table.cpp, and its module.
#pragma once

#include <variant>

#include "codegen/structures/driven_kkl.h"
#include "codegen/structures/general.h"
#include "codegen/structures/kkl.h"
#include "codegen/structures/luenberger.h"
#include "codegen/structures/window.h"

namespace nlo::codegen {

using Structure = std::variant<Kkl, DrivenKkl, Luenberger, General, Window>;

}  // namespace nlo::codegen

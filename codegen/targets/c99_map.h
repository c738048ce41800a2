// SPDX-License-Identifier: MIT
// The inverse map of an observer in C99: its weights as tables, and NAME_estimate.
#pragma once

#include <Eigen/Core>
#include <string>

#include "codegen/fold/fold.h"
#include "codegen/fold/quantise.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

/// The functions of a map in the scalar of `init`, from `dense` to NAME_estimate; `suffix` ends its literals.
std::string c99_map(const std::string& name, const Model& model, const FoldedModel& folded, const Initialiser& init,
                    const std::string& suffix);

/// The same in int16, all around it in float.
std::string c99_int16_map(const std::string& name, const Model& model, const FoldedModel& folded,
                          const QuantisedNetwork& map, const Initialiser& init);

/// `values` as an initialiser, one row per line; behind each other, as C99 cannot index past the end of a row.
std::string c99_rows(const Initialiser& init, const Eigen::MatrixXd& values, const std::string& field);

}  // namespace nlo::codegen

// SPDX-License-Identifier: MIT
// Writes the networks of an observer in C99: their weights as tables, their evaluation, and NAME_estimate.
#pragma once

#include <Eigen/Core>
#include <string>

#include "codegen/fold/fold.h"
#include "codegen/fold/quantise.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

/// Returns `dense`, the activations and their layers in the scalar of `init`, as far as the step and the map need them.
/// `suffix` ends literals. `quantised` has the parts that are in integers; null: none.
std::string c99_arithmetic(const FoldedModel& folded, const QuantisedModel* quantised, bool steps_with_tanh,
                           const Initialiser& init, const std::string& suffix);

/// Returns the tables of the networks that a step evaluates, each of one layer; empty if there are none.
std::string c99_step_networks(const FoldedModel& folded, const QuantisedModel* quantised, const Initialiser& init);

/// Returns the networks of a step as functions with their names, `dynamics(in, out)`, and their derivatives along a
/// direction, `dynamics_tangent(in, direction, out)`.
std::string c99_functions(const FoldedModel& folded, const Initialiser& init);
std::string c99_tangents(const FoldedModel& folded, const Initialiser& init, const std::string& suffix);

/// Returns the functions of a map in the scalar of `init`, including NAME_estimate.
std::string c99_map(const std::string& name, const Model& model, const FoldedModel& folded, const Initialiser& init);

/// Returns the map in int16. Its inputs and outputs are in float.
std::string c99_int16_map(const std::string& name, const Model& model, const FoldedModel& folded,
                          const QuantisedModel& quantised, const Initialiser& init);

/// Returns the size of a table. A factor of 1 is left out, because it is an operation without effect (MISRA C 2.2).
std::string c99_table_size(Eigen::Index rows, Eigen::Index columns);

/// Returns `values` as an initialiser without inner braces, one row per line, because C99 cannot index past the end of
/// a row.
std::string c99_rows(const Initialiser& init, const Eigen::MatrixXd& values, const std::string& field);

}  // namespace nlo::codegen

// SPDX-License-Identifier: MIT
// The networks of an observer in C99: their weights as tables, their evaluation, and NAME_estimate.
#pragma once

#include <Eigen/Core>
#include <string>

#include "codegen/fold/fold.h"
#include "codegen/fold/quantise.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

/// `dense`, activations and layers with them in the scalar of `init`, as far as the step and the map need them;
/// `suffix` ends literals. What of it is `quantised` in integers; null: nothing.
std::string c99_arithmetic(const FoldedModel& folded, const QuantisedModel* quantised, bool has_gates,
                           const Initialiser& init, const std::string& suffix);

/// The tables of the networks that a step evaluates, each of one layer; empty where there is none.
std::string c99_step_networks(const FoldedModel& folded, const QuantisedModel* quantised, const Initialiser& init);

/// The networks of a step as functions of their names: `dynamics(in, out)`. And their derivatives along a direction:
/// `dynamics_tangent(in, direction, out)`.
std::string c99_functions(const FoldedModel& folded, const Initialiser& init);
std::string c99_tangents(const FoldedModel& folded, const Initialiser& init, const std::string& suffix);

/// The functions of a map in the scalar of `init`, up to NAME_estimate.
std::string c99_map(const std::string& name, const Model& model, const FoldedModel& folded, const Initialiser& init);

/// The map in int16; its inputs and outputs are in float.
std::string c99_int16_map(const std::string& name, const Model& model, const FoldedModel& folded,
                          const QuantisedModel& quantised, const Initialiser& init);

/// The size of a table: a factor of 1 is an operation without effect (MISRA C 2.2).
std::string c99_table_size(Eigen::Index rows, Eigen::Index columns);

/// `values` as an initialiser, one row per line; behind each other, as C99 cannot index past the end of a row.
std::string c99_rows(const Initialiser& init, const Eigen::MatrixXd& values, const std::string& field);

}  // namespace nlo::codegen

// SPDX-License-Identifier: MIT
// What every model must satisfy before it is written, read or exported: shapes that agree, finite numbers, a latent
// system that forgets its start, names that are safe in code.
#pragma once

#include <Eigen/Core>
#include <string_view>

#include "codegen/model.h"

namespace nlo::codegen {

/// `[A-Za-z][A-Za-z0-9_]{0,62}`, no doubled underscore, no word that C++, its standard macros or a generated header
/// have taken: safe as a namespace, an enumerator and a file name.
bool is_identifier(std::string_view text);

/// Throws Error naming the field (`layers[2].weights[4][7]`), what is wrong with it and what to do.
void validate(const Model& model);

/// S = -D^-1 F, n_z x n_y: the latent state per unit of an output that stands still.
Eigen::MatrixXd steady_gain(const Model& model);

}  // namespace nlo::codegen

// SPDX-License-Identifier: MIT
// Parts of every export in any language: comments about the model, and checks of the range of a scalar.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/model/model.h"
#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// Returns "x1 [m]".
std::string channel_text(const Channel& channel);

/// Returns "x1 [m], x2 [m/s]", or "x1, x2".
std::string channel_list(const std::vector<Channel>& channels, bool with_units);

/// Returns "12 multiply-adds, 4 activations".
std::string with_activations(Eigen::Index multiply_adds, Eigen::Index activations);

/// Returns the model's provenance as comment lines with a heading; empty if there is none.
std::string facts(const Model& model);

/// Returns comment lines about the readings: the range in which each is used unchanged, and what happens beyond it.
std::string ranges_text(const PreparedExport& prepared);

/// Returns comment lines about numbers that are not plain scalars (int16, weights of 16 bits, a chosen tanh). Empty for
/// plain scalars.
std::string arithmetic_note(const PreparedExport& prepared);

/// Fills the templates in `folder` ("zephyr/") whose name `wanted` accepts. Paths are relative to it, and `name`
/// replaces NAME.
std::vector<NamedText> filled_folder(
    std::string_view folder, const std::string& name, const std::map<std::string, std::string>& values,
    const std::function<bool(std::string_view)>& wanted = [](std::string_view) { return true; });

/// Returns values for the templates of wrappers around the C99 pair of `prepared`: names, sizes, the scalar, channels
/// in words.
std::map<std::string, std::string> wrapper_values(const PreparedExport& prepared);

/// Throws Error if the scalar rounds the sample period to zero or an output's range to nothing.
void check_rounding(const Model& model, ScalarType scalar);

}  // namespace nlo::codegen

// SPDX-License-Identifier: MIT
// Parts of every export, in any language: comments about the model, and checks of a scalar's range.
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

/// "x1 [m]"
std::string channel_text(const Channel& channel);

/// "x1 [m], x2 [m/s]", or "x1, x2".
std::string channel_list(const std::vector<Channel>& channels, bool with_units);

/// "12 multiply-adds, 4 activations"
std::string with_activations(Eigen::Index multiply_adds, Eigen::Index activations);

/// The model's provenance as lines of comment, a heading above them; empty when there is none.
std::string facts(const Model& model);

/// The readings as lines of comment: the range in which each is used unchanged, and the treatment beyond.
std::string ranges_text(const PreparedExport& prepared);

/// Lines of comment on numbers that are not plain scalars (int16, weights of 16 bits, a chosen tanh). Empty for plain
/// scalars.
std::string arithmetic_note(const PreparedExport& prepared);

/// Fills the templates below `folder` ("zephyr/") whose name `wanted` accepts. Paths are relative to it, with `name` in
/// place of NAME.
std::vector<NamedText> filled_folder(
    std::string_view folder, const std::string& name, const std::map<std::string, std::string>& values,
    const std::function<bool(std::string_view)>& wanted = [](std::string_view) { return true; });

/// Values for the templates of wrappers around the C99 pair of `prepared`: names, sizes, the scalar, channels in words.
std::map<std::string, std::string> wrapper_values(const PreparedExport& prepared);

/// Throws Error when the sample period or an output's range is lost in the scalar.
void check_rounding(const Model& model, ScalarType scalar);

}  // namespace nlo::codegen

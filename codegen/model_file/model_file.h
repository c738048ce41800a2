// SPDX-License-Identifier: MIT
// Model files: JSON with the fields of codegen/model/model.h by their names, "format": "nlo-model" and a version.
// Numbers are written in their shortest form that reads back to the same bits; the same model gives the same bytes.
// Files of older versions are read too (model_upgrade.h); docs/model_files.md has the policy.
#pragma once

#include <string>
#include <string_view>

#include "codegen/model/model.h"

namespace nlo::codegen {

/// Reads and validates. Throws Error: `FILE: FIELD: reason and remedy`.
Model read_model(const std::string& path);

/// Reads a model from text. Messages name `origin` in place of the file.
Model parse_model(std::string_view json, const std::string& origin);

/// One line per matrix row. Throws Error when a number is not finite or a text is not UTF-8.
std::string to_json(const Model& model);

/// Validates, then replaces the file atomically, so that the file on disk can always be read again.
void write_model(const Model& model, const std::string& path);

/// Writes like write_model() over the file that the model was made from, whose text was `read`. Throws Error if the
/// file has changed since.
void rewrite_model(const Model& model, const std::string& path, std::string_view read);

}  // namespace nlo::codegen

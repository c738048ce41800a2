// SPDX-License-Identifier: MIT
// Model files: JSON with the fields of codegen/model/model.h by their names, "format": "nlo-model" and a version.
// Numbers are written in the shortest form that reads back to the same bits, and the same model gives the same bytes.
// Files of older versions can be read (model_upgrade.h); docs/model_files.md says for how long.
#pragma once

#include <string>
#include <string_view>

#include "codegen/model/model.h"

namespace nlo::codegen {

/// Reads and validates a model file. Throws Error: `FILE: FIELD: reason and remedy`.
Model read_model(const std::string& path);

/// Reads a model from text. Messages contain `origin` instead of a file name.
Model parse_model(std::string_view json, const std::string& origin);

/// Returns the text of a model file, with one line for each matrix row. Throws Error if a number is not finite or a
/// text is not UTF-8.
std::string to_json(const Model& model);

/// Validates a model, then replaces the file atomically, so that there is always a readable file on the disk.
void write_model(const Model& model, const std::string& path);

/// Replaces the file from which the model was read, by write_model(). `read`: the text that was read then. Throws Error
/// if the file has changed since then.
void rewrite_model(const Model& model, const std::string& path, std::string_view read);

}  // namespace nlo::codegen

// SPDX-License-Identifier: MIT
// A model prepared for export with one set of options. All code that writes, measures or judges the export shares it.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "codegen/fold/fold.h"
#include "codegen/fold/quantise.h"
#include "codegen/model/model.h"
#include "codegen/replay/export_error.h"
#include "codegen/text/cpp_structure.h"
#include "codegen/text/export_options.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

class PreparedExport {
 public:
  /// Validates, folds and, for int16, quantises the model. With `max_error` (read by error_limits()), selects the
  /// cheapest tanh with which the largest error of every state in the domain is within the limit, or the most accurate
  /// tanh if there is none. Only float with tanh has a choice. The same model and options give the same export on the
  /// same machine. Throws Error, with the remedy, if the model cannot be exported with these options.
  explicit PreparedExport(const Model& model, const ExportOptions& options = {}, const std::string& max_error = "");

  const Model& model() const { return model_; }
  const ExportOptions& options() const { return options_; }  ///< with the tanh that was chosen
  const std::string& name() const { return name_; }          ///< namespace and file name of the export
  const FoldedModel& folded() const { return folded_; }      ///< in the numbers of options()
  const QuantisedModel* quantised() const { return quantised_ ? &*quantised_ : nullptr; }  ///< for int16
  const Initialiser& initialiser() const { return initialiser_; }
  ExportSource source() const { return {model_, folded_, initialiser_, quantised()}; }

  /// Returns the error of this export's arithmetic, measured at the first call. Throws Error if too few samples are in
  /// the domain.
  const ExportError& error() const;

  /// Prepares the same model with other options. Measurements of the model itself are shared.
  PreparedExport with(const ExportOptions& options) const;

 private:
  /// The model itself, which all options share.
  struct Exact {
    explicit Exact(const Model& m) : plain(fold(m)) {}
    const FoldedModel plain;
    std::unique_ptr<const ErrorReplay> replay;  ///< made at its first use
  };

  PreparedExport(const Model& model, const ExportOptions& options, std::shared_ptr<Exact> exact);
  const ErrorReplay& replay() const;

  Model model_;
  ExportOptions options_;
  std::string name_;
  std::shared_ptr<Exact> exact_;
  FoldedModel folded_;
  std::optional<QuantisedModel> quantised_;
  Initialiser initialiser_;
  mutable std::optional<ExportError> error_;
};

/// Returns the golden replay of an export (replay_run.h).
ReplayRun run_replay(const PreparedExport& prepared);

}  // namespace nlo::codegen

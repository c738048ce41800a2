// SPDX-License-Identifier: MIT
#include "codegen/targets/prepared_export.h"

#include <utility>

#include "codegen/model_file/validate.h"
#include "codegen/targets/error_limits.h"
#include "codegen/targets/number_formats.h"

namespace nlo::codegen {
namespace {

const Model& validated(const Model& model) {
  validate(model);
  return model;
}

}  // namespace

PreparedExport::PreparedExport(const Model& model, const ExportOptions& options, std::shared_ptr<Exact> exact)
    : model_(model),
      options_(options),
      name_(export_name(model, options)),
      exact_(std::move(exact)),
      folded_(in_formats(exact_->plain, options)),
      initialiser_(options) {
  if (options.scalar == ScalarType::kInt16) quantised_ = quantise(model_, folded_);
}

PreparedExport::PreparedExport(const Model& model, const ExportOptions& options, const std::string& max_error)
    : PreparedExport(validated(model), options, std::make_shared<Exact>(model)) {
  if (max_error.empty()) return;
  const Eigen::VectorXd limits = error_limits(max_error, model_);
  if (options.scalar != ScalarType::kFloat || !has_tanh(exact_->plain)) return;
  options_.max_error = max_error;
  for (const TanhTier& tier : kTanhTiers) {
    options_.tanh = tier.kind;
    folded_ = in_formats(exact_->plain, options_);
    error_.reset();
    if (tier.kind == Activation::kTanh || (error().max.array() <= limits.array()).all()) break;
  }
}

const ErrorReplay& PreparedExport::replay() const {
  if (!exact_->replay) exact_->replay = std::make_unique<const ErrorReplay>(model_, exact_->plain);
  return *exact_->replay;
}

const ExportError& PreparedExport::error() const {
  if (!error_) error_ = replay().error(folded_, quantised(), options_.scalar);
  return *error_;
}

PreparedExport PreparedExport::with(const ExportOptions& options) const {
  return PreparedExport(model_, options, exact_);
}

ReplayRun run_replay(const PreparedExport& p) {
  return run_replay(p.model(), p.folded(), p.quantised(), p.options());
}

}  // namespace nlo::codegen

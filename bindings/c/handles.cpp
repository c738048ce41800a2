// SPDX-License-Identifier: MIT
#include "bindings/c/handles.h"

#include <cstdint>
#include <cstdio>
#include <limits>

#include "codegen/model_file/model_file.h"

namespace nlo::c_interface {
namespace {

thread_local char last_error[2048] = "";  // a fixed array, because storing an error must not fail

}  // namespace

int keep(int code, const char* text) noexcept {
  std::snprintf(last_error, sizeof last_error, "%s", text);
  return code;
}

Loaded::Loaded(Model read) : json(codegen::to_json(read)), structure(structure_name(read)), model(std::move(read)) {
  model.flight = {};
  outputs = measured_channels(model);
  inputs = codegen::inputs(model);
  const auto nu = static_cast<Eigen::Index>(inputs.size());
  input_max = VectorXd::Constant(nu, std::numeric_limits<double>::infinity());
  input_min = -input_max;
  if (!model.inputs.empty()) {
    input_min = model.input_min;
    input_max = model.input_max;
  }
}

const std::vector<codegen::Channel>* Loaded::channels(int kind) const {
  switch (kind) {
    case NLO_OUTPUT:
      return &outputs;
    case NLO_INPUT:
      return &inputs;
    case NLO_STATE:
      return &model.states;
    default:
      return nullptr;
  }
}

MatrixXd Loaded::with_computed(const double* y, Eigen::Index samples) const {
  const auto given = static_cast<Eigen::Index>(outputs.size());
  MatrixXd all = MatrixXd::Zero(model.ny(), samples);
  all.topRows(given) = ConstRows(y, given, samples);
  return all;
}

MatrixXd Loaded::given_inputs(const double* u, Eigen::Index samples) const {
  if (inputs.empty()) return MatrixXd(0, samples);
  need(u, "u");
  return ConstRows(u, static_cast<Eigen::Index>(inputs.size()), samples);
}

AnyObserver observer_of(const Model& model, int precision) {
  if (precision == NLO_FLOAT) return codegen::ReferenceObserver<float>(model);
  if (precision == NLO_DOUBLE) return codegen::ReferenceObserver<double>(model);
  throw BadArgument("precision is " + std::to_string(precision) + ": it must be NLO_FLOAT or NLO_DOUBLE");
}

Eigen::Index columns(std::size_t count) {
  if (count > std::numeric_limits<std::int32_t>::max()) throw BadArgument("more than 2^31 - 1 samples at once");
  return static_cast<Eigen::Index>(count);
}

}  // namespace nlo::c_interface

extern "C" const char* nlo_last_error(void) {
  return nlo::c_interface::last_error;
}

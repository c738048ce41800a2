// SPDX-License-Identifier: MIT
// Writes model files, and has the entry points; parse_model() is in model_reader.cpp.
#include "codegen/model_file/model_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <utility>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "codegen/base/number.h"
#include "codegen/base/vlq.h"
#include "codegen/model/hold.h"
#include "codegen/model/json_object.h"
#include "codegen/model_file/model_upgrade.h"
#include "codegen/model_file/monitor_fields.h"
#include "codegen/model_file/validate.h"
#include "codegen/structures/structure_module.h"

namespace nlo::codegen {
namespace {

std::string facts(const std::vector<std::pair<std::string, std::string>>& list) {
  std::string text = "{";
  for (std::size_t i = 0; i < list.size(); ++i)
    text += (i == 0 ? "\n    " : ",\n    ") + json_text(list[i].first) + ": " + json_text(list[i].second);
  return text + (list.empty() ? "}" : "\n  }");
}

std::string counts(const Eigen::MatrixXi& channels) {
  std::string text = "[";
  for (Eigen::Index j = 0; j < channels.rows(); ++j)
    text += std::string(j == 0 ? "\"" : ", \"") + to_vlq(channels.row(j)) + "\"";
  return text + "]";
}

std::string flight(const Flight& f, const std::string& indent) {
  JsonObject object(indent);
  object.vector("output_step", f.output_step);
  object.vector("input_step", f.input_step);
  object.field("dt_step_s", literal(f.dt_step_s));
  std::string runs = "[";
  for (const FlightRun& run : f.runs) {
    runs += (runs.size() == 1 ? "\n" : ",\n") + object.inner() + "  {\"outputs\": " + counts(run.outputs);
    if (run.inputs.size() != 0) runs += ", \"inputs\": " + counts(run.inputs);
    if (run.dt.size() != 0) runs += ", \"dt\": " + counts(run.dt.transpose());
    runs += "}";
  }
  object.field("runs", runs + "\n" + object.inner() + "]");
  return object.text();
}

}  // namespace

std::string to_json(const Model& m) {
  JsonObject file;
  file.field("format", "\"nlo-model\"");
  file.field("version", std::to_string(kModelVersion));
  file.text("structure", structure_name(m));
  file.text("name", m.name);
  file.channels("outputs", m.outputs);
  file.channels("states", m.states);
  if (!m.inputs.empty()) {
    file.channels("inputs", m.inputs);
    file.text("input_hold", hold_name(m.input_hold));
    file.vector("input_min", m.input_min);
    file.vector("input_max", m.input_max);
  }
  if (!m.failures.none()) {
    JsonObject failures(file.inner());
    failures.field("outputs",
                   fmt::format("[{}]", fmt::join(m.failures.outputs.begin(), m.failures.outputs.end(), ", ")));
    failures.vector("rest", m.failures.rest);
    failures.field("staleness_s", literal(m.failures.staleness_s));
    file.field("may_fail", failures.text());
  }
  file.field("provenance", facts(m.provenance));
  file.field("sample_period_s", literal(m.sample_period_s));
  file.text("hold", hold_name(m.hold));
  file.vector("initial_latent", m.initial_latent);
  file.vector("output_min", m.output_min);
  file.vector("output_max", m.output_max);
  file.vector("latent_min", m.latent_min);
  file.vector("latent_max", m.latent_max);
  if (m.saturates()) file.field("saturation", literal(m.saturation));
  module_of(m).write(m, file);
  if (m.monitor) file.field("monitor", monitor_json(*m.monitor, file.inner()));
  if (m.error) {
    JsonObject error(file.inner());
    error.matrix("weights", m.error->weights);
    error.vector("bias", m.error->bias);
    error.vector("log_min", m.error->log_min);
    error.vector("log_max", m.error->log_max);
    error.vector("factor_68", m.error->factor_68);
    error.vector("factor_95", m.error->factor_95);
    file.field("error", error.text());
  }
  if (!m.flight.runs.empty()) file.field("flight", flight(m.flight, file.inner()));
  return file.text() + "\n";
}

namespace {

std::string checked_json(const Model& model, const std::string& path) {
  try {
    validate(model);
  } catch (const Error& error) {
    throw Error(path + ": not written: " + error.what());
  }
  return to_json(model);
}

}  // namespace

void write_model(const Model& model, const std::string& path) {
  write_file_atomically(path, checked_json(model, path));
}

void rewrite_model(const Model& model, const std::string& path, std::string_view read) {
  rewrite_file_atomically(path, read, checked_json(model, path));
}

Model read_model(const std::string& path) {
  return parse_model(read_file(path), path);
}

}  // namespace nlo::codegen

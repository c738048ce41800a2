// SPDX-License-Identifier: MIT
// Lists the structures (structures.h has their types in the same order), and implements codegen/model/model.h for all
// models.
#include <algorithm>
#include <array>
#include <cstddef>

#include "codegen/model/computed_outputs.h"
#include "codegen/structures/structure_module.h"

namespace nlo::codegen {

// Each is defined in its own file.
const StructureModule& kkl_module();
const StructureModule& driven_kkl_module();
const StructureModule& luenberger_module();
const StructureModule& general_module();
const StructureModule& gated_module();
const StructureModule& carried_module();
const StructureModule& prior_module();

const std::vector<const StructureModule*>& structure_modules() {
  static const std::vector<const StructureModule*> kModules = {
      &kkl_module(),   &driven_kkl_module(), &luenberger_module(), &general_module(),
      &gated_module(), &carried_module(),    &prior_module()};
  return kModules;
}

const StructureModule& module_of(const Model& m) {
  return *structure_modules()[m.structure.index()];
}

const StructureModule* find_structure(std::string_view name) {
  for (const StructureModule* module : structure_modules())
    if (module->name() == name) return module;
  return nullptr;
}

int Model::measured() const {
  return measured_outputs(outputs);
}

int Model::nu() const {
  return static_cast<int>(codegen::inputs(*this).size());
}

std::string_view structure_name(const Model& m) {
  return module_of(m).name();
}

std::vector<Named<Network>> networks(Model& m) {
  return module_of(m).networks(m);
}

std::vector<Named<const Network>> networks(const Model& m) {
  std::vector<Named<const Network>> list;
  for (const Named<Network>& n : networks(const_cast<Model&>(m))) list.push_back({n.field, n.network, n.reads});
  return list;
}

Network* inverse_map(Model& m) {
  return module_of(m).inverse_map(m);
}
const Network* inverse_map(const Model& m) {
  return inverse_map(const_cast<Model&>(m));  // a module does not change it
}

LinearLatent* linear_latent(Model& m) {
  return module_of(m).linear_latent(m);
}
const LinearLatent* linear_latent(const Model& m) {
  return linear_latent(const_cast<Model&>(m));
}

const std::vector<Channel>& inputs(const Model& m) {
  return module_of(m).inputs(m);
}

Model without_inputs(Model m) {
  m.structure = module_of(m).without_inputs(m);
  return m;
}

std::vector<Channel> measured_channels(const Model& m) {
  return {m.outputs.begin(), m.outputs.begin() + m.measured()};
}

namespace {

/// Returns the bounds of the outputs, the inputs and the stalenesses in one vector.
Eigen::VectorXd stacked(const Model& m, const Eigen::VectorXd& outputs, const Eigen::VectorXd& inputs, double stale) {
  Eigen::VectorXd all(m.nr());
  all << outputs, inputs, Eigen::VectorXd::Constant(static_cast<Eigen::Index>(m.failures.outputs.size()), stale);
  return all;
}

}  // namespace

std::vector<Channel> readings(const Model& m) {
  std::vector<Channel> both = m.outputs;
  both.insert(both.end(), m.inputs.begin(), m.inputs.end());
  for (const int output : m.failures.outputs)
    both.push_back({m.outputs[static_cast<std::size_t>(output)].name + "_staleness", "", 0.0});
  return both;
}

Eigen::VectorXd reading_min(const Model& m) {
  return stacked(m, m.output_min, m.input_min, 0.0);
}
Eigen::VectorXd reading_max(const Model& m) {
  return stacked(m, m.output_max, m.input_max, 1.0);
}

bool is_relative(const Model& m, int output) {
  if (output >= m.ny()) return false;  // an input
  if (m.outputs[static_cast<std::size_t>(output)].wrap > 0.0) return true;
  const LinearLatent* latent = linear_latent(m);
  return latent != nullptr && std::find(latent->relative_outputs.begin(), latent->relative_outputs.end(), output) !=
                                  latent->relative_outputs.end();
}

bool saturates_relative(const Model& m) {
  for (int j = 0; m.saturates() && j < m.nr(); ++j)
    if (is_relative(m, j)) return true;
  return false;
}

}  // namespace nlo::codegen

// SPDX-License-Identifier: MIT
// The interface to all code that depends on a model's structure. Each structure has one module, a file in this folder;
// structure_modules.cpp lists them. Other code calls module_of(model) or the functions of codegen/model/model.h and
// does not depend on which structure a model has.
#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "codegen/base/json_field.h"
#include "codegen/model/contraction.h"
#include "codegen/model/folded.h"
#include "codegen/model/json_object.h"
#include "codegen/model/model.h"
#include "codegen/reference/dynamics.h"
#include "codegen/text/cpp_structure.h"

namespace nlo::codegen {

/// Exports that a structure supports beside the C++ header in float and double.
struct Abilities {
  bool c99 = false;    ///< target c99
  bool int16 = false;  ///< --scalar int16: the model of the runtime takes a QuantisedMap
};

class StructureModule {
 public:
  virtual ~StructureModule() = default;

  virtual std::string_view name() const = 0;  ///< in model files and experiments: "kkl"

  // The model file.

  /// Returns the fields of this structure, without those that all models have.
  virtual std::vector<const char*> keys() const = 0;
  /// Sets model.structure from these fields.
  virtual void read(const Field& file, Model& model) const = 0;
  virtual void write(const Model& model, JsonObject& file) const = 0;
  /// Throws Error with the field, the reason and the remedy. The common fields of all models have been checked before.
  virtual void check(const Model& model) const = 0;

  // Properties that other code needs (codegen/model/model.h).

  virtual std::vector<Named<Network>> networks(Model& model) const = 0;
  virtual Network* inverse_map(Model& model) const = 0;
  virtual LinearLatent* linear_latent(Model&) const { return nullptr; }
  virtual const std::vector<Channel>& inputs(const Model& model) const { return model.inputs; }
  /// Returns the observer without inputs.
  virtual Structure without_inputs(const Model& model) const { return model.structure; }
  /// Returns how inputs(model) change between two samples.
  virtual Hold input_hold(const Model& model) const { return model.input_hold; }
  /// Returns true if a model may have Model::inputs.
  virtual bool reads_inputs() const { return true; }
  /// Returns true if outputs may be computed from others.
  virtual bool computes_outputs() const { return false; }
  /// Returns true if a model may have Model::failures.
  virtual bool reads_stalenesses() const { return false; }
  /// Returns true if its states are directions: vectors of three components and length 1, whose error is the angle to
  /// the truth.
  virtual bool estimates_directions(const Model&) const { return false; }
  /// Returns true if the latent system has the equations of the plant.
  virtual bool has_known_equations() const { return false; }
  /// Returns the number of gated units, which are the first coordinates of z.
  virtual Eigen::Index gated_units(const Model&) const { return 0; }
  /// Returns true if a step may overflow, so that its status may be kDiverged.
  virtual bool may_diverge() const { return false; }
  /// Returns true if a model may have Model::saturation.
  virtual bool saturates() const { return false; }
  /// Returns true if features of T* may be multiplied by clocks.
  virtual bool multiplies_by_clocks() const { return false; }
  /// Returns the bound of |z| for any measurements, n_z, if the equations imply one.
  virtual std::optional<Eigen::VectorXd> latent_limit(const Model&) const { return std::nullopt; }
  /// Returns the contraction that the weights prove: Contraction::none() if they prove none, empty if no proof is
  /// known.
  virtual std::optional<Contraction> contraction(const Model&) const { return std::nullopt; }
  /// Returns the rates of the fastest and the slowest mode that reads an output [1/s]; empty if no mode is known.
  virtual std::optional<double> fastest_mode(const Model&) const { return std::nullopt; }
  virtual std::optional<double> slowest_mode(const Model&) const { return std::nullopt; }

  // The equations as in the paper: codegen/replay/reference_observer.h steps them. The model must outlive the result.

  virtual std::unique_ptr<ReferenceDynamics<float>> dynamics_in_float(const Model&, Activations) const = 0;
  virtual std::unique_ptr<ReferenceDynamics<double>> dynamics_in_double(const Model&, Activations) const = 0;

  /// Returns dynamics with gated units in integers, which must outlive the result. Only if all of z are gated units.
  virtual std::unique_ptr<ReferenceDynamics<float>> dynamics_in_integers(const Model&, const QuantisedUnits&) const {
    return nullptr;
  }

  // Exports.

  virtual Abilities abilities() const { return {}; }
  /// Returns the structure's part of a C++ header. All arguments must outlive the result.
  virtual std::unique_ptr<CppStructure> cpp(const ExportSource& source) const = 0;
  /// Returns the structure's values for templates/c99 by name. LATENT (how z moves) names a template, and if there is a
  /// steady state, so do WARM_START and WARM_START_BODY. Only if abilities().c99.
  virtual std::map<std::string, std::string> c99(const ExportSource&) const { return {}; }
};

/// Returns all modules, in the order of the variant Structure.
const std::vector<const StructureModule*>& structure_modules();

const StructureModule& module_of(const Model& model);

/// Returns the module with this name, or null.
const StructureModule* find_structure(std::string_view name);

/// Returns the names of all modules for which `has` holds: "kkl, general".
template <class Has>
std::string names_of_structures(const Has& has) {
  std::string names;
  for (const StructureModule* module : structure_modules())
    if (has(*module)) names += (names.empty() ? "" : ", ") + std::string(module->name());
  return names;
}

/// Base of a module for the alternative `Own`, with access to its part of a model.
template <class Own>
const Own& own_part(const Model& model) {
  return std::get<Own>(model.structure);
}
template <class Own>
Own& own_part(Model& model) {
  return std::get<Own>(model.structure);
}

}  // namespace nlo::codegen

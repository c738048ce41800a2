// SPDX-License-Identifier: MIT
// The interface to everything that depends on a model's structure. Each structure has one module, a file in this
// folder; structure_modules.cpp lists them. Other code calls module_of(model) or the functions of codegen/model/model.h
// and never asks which structure a model has.
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

/// Exports that a structure has beside the C++ header in float and double.
struct Abilities {
  bool c99 = false;    ///< target c99
  bool int16 = false;  ///< --scalar int16: the runtime's model takes a QuantisedMap
};

class StructureModule {
 public:
  virtual ~StructureModule() = default;

  virtual std::string_view name() const = 0;  ///< in model files and experiments: "kkl"

  // The model file.

  /// Its fields, beside those that all models have.
  virtual std::vector<const char*> keys() const = 0;
  /// Sets model.structure from them.
  virtual void read(const Field& file, Model& model) const = 0;
  virtual void write(const Model& model, JsonObject& file) const = 0;
  /// Throws Error with the field, the reason and the remedy. The common fields of all models have been checked before.
  virtual void check(const Model& model) const = 0;

  // Questions of other code (codegen/model/model.h).

  virtual std::vector<Named<Network>> networks(Model& model) const = 0;
  virtual Network* inverse_map(Model& model) const = 0;
  virtual LinearLatent* linear_latent(Model&) const { return nullptr; }
  virtual const std::vector<Channel>& inputs(const Model& model) const { return model.inputs; }
  /// The observer without inputs.
  virtual Structure without_inputs(const Model& model) const { return model.structure; }
  /// How inputs(model) move between two samples.
  virtual Hold input_hold(const Model& model) const { return model.input_hold; }
  /// Model::inputs may be there.
  virtual bool reads_inputs() const { return true; }
  /// Outputs may be computed of others.
  virtual bool computes_outputs() const { return false; }
  /// Model::failures may be there.
  virtual bool reads_stalenesses() const { return false; }
  /// Its states are directions: vectors of three components and length 1, whose angle to the truth is the error.
  virtual bool estimates_directions(const Model&) const { return false; }
  /// Its step is that of `gates` and `candidate` alone.
  virtual bool has_gated_units() const { return false; }
  /// A step may overflow: its status may be kDiverged.
  virtual bool may_diverge() const { return false; }
  /// Model::saturation may be there.
  virtual bool saturates() const { return false; }
  /// Features of T* may be multiplied by clocks.
  virtual bool multiplies_by_clocks() const { return false; }
  /// Bound of |z| for any measurements, n_z, if the equations imply one.
  virtual std::optional<Eigen::VectorXd> latent_limit(const Model&) const { return std::nullopt; }
  /// The contraction that the weights prove: Contraction::none() if they prove none, nothing if no proof is known.
  virtual std::optional<Contraction> contraction(const Model&) const { return std::nullopt; }
  /// Rates of the fastest and the slowest mode that reads an output [1/s]; nothing where no mode is known.
  virtual std::optional<double> fastest_mode(const Model&) const { return std::nullopt; }
  virtual std::optional<double> slowest_mode(const Model&) const { return std::nullopt; }

  // The equations as they stand in the paper: codegen/replay/reference_observer.h steps them.
  // The model must outlive the result.

  virtual std::unique_ptr<ReferenceDynamics<float>> dynamics_in_float(const Model&, Activations) const = 0;
  virtual std::unique_ptr<ReferenceDynamics<double>> dynamics_in_double(const Model&, Activations) const = 0;

  /// With gated units in integers, which must outlive the result. Only where has_gated_units().
  virtual std::unique_ptr<ReferenceDynamics<float>> dynamics_in_integers(const Model&, const QuantisedUnits&) const {
    return nullptr;
  }

  // Exports.

  virtual Abilities abilities() const { return {}; }
  /// Its part of a C++ header. All arguments must outlive the result.
  virtual std::unique_ptr<CppStructure> cpp(const ExportSource& source) const = 0;
  /// Its part of templates/c99: values by name. LATENT (how z moves), and where it has a steady state WARM_START and
  /// WARM_START_BODY, name templates of its own. Only with abilities().c99.
  virtual std::map<std::string, std::string> c99(const ExportSource&) const { return {}; }
};

/// All of them, in the order of the variant Structure.
const std::vector<const StructureModule*>& structure_modules();

const StructureModule& module_of(const Model& model);

/// The module of that name; null when there is none.
const StructureModule* find_structure(std::string_view name);

/// The names of all modules for which `has` holds: "kkl, general".
template <class Has>
std::string names_of_structures(const Has& has) {
  std::string names;
  for (const StructureModule* module : structure_modules())
    if (has(*module)) names += (names.empty() ? "" : ", ") + std::string(module->name());
  return names;
}

/// For a module of the alternative `Own`: its part of a model.
template <class Own>
const Own& own_part(const Model& model) {
  return std::get<Own>(model.structure);
}
template <class Own>
Own& own_part(Model& model) {
  return std::get<Own>(model.structure);
}

}  // namespace nlo::codegen

// SPDX-License-Identifier: MIT
// The part of a generated C++ header that depends on the structure. Each structure's module has its own.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "codegen/model/folded.h"
#include "codegen/model/model.h"
#include "codegen/text/cpp_network.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

/// The model and the numbers from which an export is generated.
struct ExportSource {
  const Model& model;
  const FoldedModel& folded;
  const Initialiser& init;
  const QuantisedModel* quantised = nullptr;  ///< parts in int16; null: none
};

class CppStructure {
 public:
  virtual ~CppStructure() = default;

  virtual std::string title() const = 0;        ///< "a learned state observer (...)"
  virtual std::string description() const = 0;  ///< lines of comment
  virtual std::string header() const = 0;       ///< "kkl_observer.h"
  virtual std::vector<CppNetwork> networks() const = 0;
  virtual std::string declarations() const { return ""; }  ///< declarations that the model's type needs
  virtual std::string model_type() const = 0;       ///< "KklModel<float, 2, 1, 5>;  // n_x, n_y, n_z" and a new line
  virtual std::string observer() const = 0;         ///< "KklObserver"
  virtual std::string leading_fields() const = 0;   ///< fields of kModel between stale_after and outputs
  virtual std::string trailing_fields() const = 0;  ///< fields of kModel behind domain

  virtual Eigen::Index step_multiply_adds() const = 0;
  virtual Eigen::Index step_activations() const = 0;
  virtual Eigen::Index estimate_multiply_adds() const = 0;
  virtual Eigen::Index estimate_activations() const = 0;
  /// Instructions of a step on a Cortex-M4 beyond its multiply-adds and activations (cortex_m4_time()).
  virtual Eigen::Index further_instructions() const { return 0; }
  virtual Eigen::Index own_scalars() const = 0;  ///< number of constants beyond those of every structure, with padding
};

/// Base of most structures: the estimate costs as much as the inverse map, and the networks are the last part of
/// kModel.
class CppStructureBase : public CppStructure {
 public:
  explicit CppStructureBase(const ExportSource& source);

  std::string trailing_fields() const override;
  Eigen::Index estimate_multiply_adds() const override { return inverse_map().multiply_adds(); }
  Eigen::Index estimate_activations() const override { return inverse_map().activations(); }

 protected:
  CppNetwork inverse_map() const;
  virtual bool may_saturate() const { return false; }  ///< the model of the runtime has an argument for saturation
  /// Returns the last arguments of the type of a model that reads inputs, has sensors that may fail, or saturates: ",
  /// 2", ", 2, Hold::kFirstOrder", ", 0, Hold::kZeroOrder, 0, Saturation::kLatent". Empty for other models.
  std::string input_arguments() const;
  std::string input_words() const;             ///< their names in a comment: ", n_u, hold of u"
  std::string input_comment() const;           ///< lines of description; may be empty
  std::string reads(bool latent_alone) const;  ///< the readings of a network: "[z; y; u]"
  /// Returns the network of a field of the model file, with its names in the header.
  CppNetwork network(const std::string& field, const std::string& layer, const std::string& type,
                     const std::string& reads) const;

  const Model& m_;
  const FoldedModel& f_;
  const Initialiser& init_;
  const QuantisedModel* quantised_;
  const Eigen::Index nx_, ny_, nr_, read_inputs_, nz_;  ///< nr_: readings
};

/// Returns "Hold::kRk4" for kRk4, and so on.
std::string hold_identifier(Hold hold);

}  // namespace nlo::codegen

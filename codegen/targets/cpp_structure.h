// SPDX-License-Identifier: MIT
// What a structure puts into its generated header: one class per structure, one factory. A new structure is one class
// more in cpp_structure.cpp.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "codegen/fold.h"
#include "codegen/model.h"
#include "codegen/targets/cpp_network.h"
#include "codegen/targets/generated_text.h"

namespace nlo::codegen {

class CppStructure {
 public:
  virtual ~CppStructure() = default;

  virtual std::string title() const = 0;        ///< "a learned state observer (...)"
  virtual std::string description() const = 0;  ///< lines of comment
  virtual std::string header() const = 0;       ///< "kkl_observer.h"
  virtual std::vector<CppNetwork> networks() const = 0;
  virtual std::string types() const = 0;            ///< Model and Observer
  virtual std::string leading_fields() const = 0;   ///< of kModel, between stale_after and outputs
  virtual std::string trailing_fields() const = 0;  ///< of kModel, behind domain

  virtual Eigen::Index step_multiply_adds() const = 0;
  virtual Eigen::Index step_activations() const = 0;
  virtual Eigen::Index estimate_multiply_adds() const = 0;
  virtual Eigen::Index estimate_activations() const = 0;
  virtual Eigen::Index own_scalars() const = 0;  ///< of constants, beside those that all have; padding counts as whole
};

/// The structure of `model`, its inverse map in int16 when `quantised` is given; all arguments must outlive it.
std::unique_ptr<CppStructure> cpp_structure(const Model& model, const FoldedModel& folded, const Initialiser& init,
                                            const QuantisedNetwork* quantised = nullptr);

}  // namespace nlo::codegen

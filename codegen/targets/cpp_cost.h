// SPDX-License-Identifier: MIT
// The cost of an observer in a generated C++ header, as far as it depends on the model only.
#pragma once

#include <Eigen/Core>

#include "codegen/model/model.h"
#include "codegen/targets/prepared_export.h"
#include "codegen/text/cpp_structure.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

struct CppCost {
  Eigen::Index step_multiply_adds = 0, step_activations = 0;
  Eigen::Index estimate_multiply_adds = 0, estimate_activations = 0;
  Eigen::Index further_instructions = 0;  ///< instructions for integrating the plant's equations
  Eigen::Index constant_bytes = 0;        ///< sizeof(Model)
  Eigen::Index observer_bytes = 0;        ///< sizeof(Observer) for pointers of 32 bits

  Eigen::Index multiply_adds() const { return step_multiply_adds + estimate_multiply_adds; }
  Eigen::Index activations() const { return step_activations + estimate_activations; }
};
CppCost cpp_cost(const Model& model, const CppStructure& structure, const Initialiser& init);
CppCost cpp_cost(const PreparedExport& prepared);

/// Bounds of the time [us] of a step and an estimate in float on a Cortex-M4 with an FPU:
///   2.2 M / f  to  (4.3 M + 30 A + 3000 + E) / f    M multiply-adds, A activations, E further_instructions,
///                                                   f the clock [MHz]
/// The instructions counted on an emulated core (docs/performance.md) are between 1.2 M and 1.3 M + 30 A + 3000 + E for
/// both policies. Each weight takes one more cycle to load, and a multiply-add takes one to three cycles. Weights in a
/// flash with 5 wait states per 16 bytes add up to 1.25 M / f.
struct Microseconds {
  double least, most;
};
Microseconds cortex_m4_time(const CppCost& cost, double clock_mhz);

}  // namespace nlo::codegen

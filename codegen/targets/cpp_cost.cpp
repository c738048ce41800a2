// SPDX-License-Identifier: MIT
#include "codegen/targets/cpp_cost.h"

#include "codegen/structures/structure_module.h"

namespace nlo::codegen {

CppCost cpp_cost(const Model& m, const CppStructure& structure, const Initialiser& init) {
  const Eigen::Index nz = m.nz(), ny = m.ny(), nu = m.nu();
  const auto bytes = static_cast<Eigen::Index>(init.scalar_bytes());
  CppCost cost;
  cost.step_multiply_adds = structure.step_multiply_adds();
  cost.step_activations = structure.step_activations();
  cost.further_instructions = structure.further_instructions();
  cost.estimate_multiply_adds = structure.estimate_multiply_adds();
  cost.estimate_activations = structure.estimate_activations();
  // Sample period, output range, domain, the structure's own numbers, the networks.
  cost.constant_bytes = bytes * (1 + 3 * m.nr() + 2 * nz + structure.own_scalars());
  for (const CppNetwork& network : structure.networks()) cost.constant_bytes += network.constant_bytes(init);
  const auto failing = static_cast<Eigen::Index>(m.failures.outputs.size());
  constexpr Eigen::Index kInt = 4;  // index of an output; padded to whole scalars
  if (failing > 0) cost.constant_bytes += bytes * (failing + 2 + (kInt * failing + bytes - 1) / bytes);
  const Eigen::Index channels = ny + nu + failing;
  const Eigen::Index scalars = (2 * channels + 2 + bytes - 1) / bytes;  // for the health and the flags of the channels
  cost.observer_bytes = bytes * (1 + nz + channels + scalars);          // pointer (32 bit, padded), z, y, u
  return cost;
}

CppCost cpp_cost(const PreparedExport& prepared) {
  return cpp_cost(prepared.model(), *module_of(prepared.model()).cpp(prepared.source()), prepared.initialiser());
}

Microseconds cortex_m4_time(const CppCost& cost, double clock_mhz) {
  const auto m = static_cast<double>(cost.multiply_adds()), a = static_cast<double>(cost.activations()),
             e = static_cast<double>(cost.further_instructions);
  return {2.2 * m / clock_mhz, (4.3 * m + 30.0 * a + 3000.0 + e) / clock_mhz};
}

}  // namespace nlo::codegen

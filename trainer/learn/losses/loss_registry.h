// SPDX-License-Identifier: MIT
// The terms of the cost (9). Each entry has the name of its weight under [loss], its requirements, and a function for
// its value and cotangent. To add a term, add a file to this folder and a line to loss_registry.cpp: keys, help, checks
// and training use the table.
#pragma once

#include <string_view>
#include <variant>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/gradients/nn/network_block.h"

namespace nlo::trainer {

class EstimateBlock;
template <class Scalar, int kColumns>
class MapBlock;
template <class Scalar>
struct MapSamples;

/// A term of x_hat at a block of samples. Adds its value to `loss` and its cotangent to the block.
///   share  the weight of the term times the share of a sample of weight 1
struct EstimateLoss {
  enum class At { kSamples, kSegmentEnds } at;
  void (*add)(EstimateBlock& block, double share, bool backward, double& loss);
};

/// A term of T(x), which may also read z and T*. Returns the weighted value, and adds dl/dT to the block and dl/dz to
/// `cotangent_z` (null: only the value is computed).
struct MapLoss {
  double (*value)(MapBlock<float, kBlock>& block, const MapSamples<float>& samples, double weight, float* cotangent_z);
};

/// A term of T and its derivative along f(x), at the samples or at collocation points. It evaluates T itself.
struct EquationLoss {
  double (*value)(MapBlock<float, kBlock>& block, const MapSamples<float>& samples, double weight, bool backward);
};

/// A term of one learned parameter of the eigenvalues. Adds its value to `loss` and returns its slope.
///   share  the weight of the term times the horizon
struct EigenvalueLoss {
  double (*add)(double share, double lambda, double& loss);
};

struct LossTerm {
  std::string_view name;           ///< the key of its weight
  std::string_view meaning;        ///< one line for the help
  bool needs_forward_map = false;  ///< the term trains T
  bool needs_eigenvalues = false;  ///< depends on D, which only KKL observers have
  bool needs_equations = false;    ///< needs f and h of the plant
  std::variant<EstimateLoss, MapLoss, EquationLoss, EigenvalueLoss> form;

  /// Returns true for a penalty on parameters, from which alone nothing can be learned.
  bool is_regulariser() const { return std::holds_alternative<EigenvalueLoss>(form); }
};

/// Returns all terms in the order of their keys. The first is the running state error.
const std::vector<LossTerm>& loss_terms();

/// Returns true if a term with a weight trains T, which needs f and h of the plant.
bool needs_forward_map(const LossConfig& config);
bool needs_equations(const LossConfig& config);

/// Calls run(form, weight) for every term of type Form that has a weight.
template <class Form, class Run>
void for_each_loss(const LossConfig& config, const Run& run) {
  for (const LossTerm& term : loss_terms()) {
    const double weight = config.weight(term.name);
    if (const Form* form = std::get_if<Form>(&term.form); form != nullptr && weight > 0.0) run(*form, weight);
  }
}

/// Returns true if at least one term of type Form has a weight and is(form) is true for it.
template <class Form, class Is>
bool any_loss(const LossConfig& config, const Is& is) {
  bool found = false;
  for_each_loss<Form>(config, [&](const Form& form, double) { found = found || is(form); });
  return found;
}
template <class Form>
bool has_loss(const LossConfig& config) {
  return any_loss<Form>(config, [](const Form&) { return true; });
}

}  // namespace nlo::trainer

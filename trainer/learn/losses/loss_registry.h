// SPDX-License-Identifier: MIT
// The terms of the cost (9), one entry each: the name of its weight under [loss], its requirements, and its value
// with its cotangent. A new term is a file beside this one and a line in loss_registry.cpp: keys, help, checks and
// training run over the table.
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
///   share  the term's weight times the share of a sample of weight 1
struct EstimateLoss {
  enum class At { kSamples, kSegmentEnds } at;
  void (*add)(EstimateBlock& block, double share, bool backward, double& loss);
};

/// A term of T(x), with z and T* beside it. Returns the weighted value, and adds dl/dT to the block and dl/dz to
/// `cotangent_z` (null: only the value is wanted).
struct MapLoss {
  double (*value)(MapBlock<float, kBlock>& block, const MapSamples<float>& samples, double weight, float* cotangent_z);
};

/// A term of T and its derivative along f(x), at the samples or at collocation points. It runs T itself.
struct EquationLoss {
  double (*value)(MapBlock<float, kBlock>& block, const MapSamples<float>& samples, double weight, bool backward);
};

/// A term of one learned entry of the eigenvalues. Adds its value to `loss` and returns its slope.
///   share  the term's weight times the horizon
struct EigenvalueLoss {
  double (*add)(double share, double lambda, double& loss);
};

struct LossTerm {
  std::string_view name;           ///< the key of its weight
  std::string_view meaning;        ///< a line of help
  bool needs_forward_map = false;  ///< trains T
  bool needs_eigenvalues = false;  ///< is about D: KKL observers alone have it
  bool needs_equations = false;    ///< asks the plant for f and h
  std::variant<EstimateLoss, MapLoss, EquationLoss, EigenvalueLoss> form;

  /// Nothing is learned from it alone.
  bool is_regulariser() const { return std::holds_alternative<EigenvalueLoss>(form); }
};

/// In the order of their keys; the first is the running state error.
const std::vector<LossTerm>& loss_terms();

/// Whether a term with a weight trains T; asks the plant for f and h.
bool needs_forward_map(const LossConfig& config);
bool needs_equations(const LossConfig& config);

/// Calls run(form, weight) for every term of that form that has a weight.
template <class Form, class Run>
void for_each_loss(const LossConfig& config, const Run& run) {
  for (const LossTerm& term : loss_terms()) {
    const double weight = config.weight(term.name);
    if (const Form* form = std::get_if<Form>(&term.form); form != nullptr && weight > 0.0) run(*form, weight);
  }
}

/// Whether one of that form, for which is(form) holds, has a weight.
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

// SPDX-License-Identifier: MIT
#include "trainer/structures/kkl_family.h"

#include <algorithm>

#include "trainer/base/draws.h"
#include "trainer/structures/kkl_lanes.h"
#include "trainer/structures/linear_latent_start.h"
#include "trainer/structures/model_networks.h"

namespace nlo::trainer {
namespace {

/// Returns the trained D and F. Sets the initial values of the clocks in the model.
codegen::LinearLatent linear_latent_of(const ObserverStructure& structure, const float* parameters,
                                       codegen::Model& model) {
  const LatentShape& latent = structure.latent;
  const std::vector<double> eigenvalues = structure.eigenvalues_at(parameters);
  codegen::LinearLatent result;
  result.eigenvalues = Eigen::Map<const Eigen::VectorXd>(eigenvalues.data(), latent.rows);
  result.output_injection = Eigen::MatrixXd::Zero(latent.rows, model.nr());
  result.starts_steady = latent.starts_steady;
  for (const Mode& mode : latent.modes) {
    if (mode.pair) ++result.pairs;
    if (mode.reading < 0) {
      model.initial_latent(mode.row) = 1.0;
      continue;
    }
    const std::complex<double> f = injection_of(latent.injection, mode, eigenvalue_of(mode, eigenvalues));
    result.output_injection(mode.row, mode.reading) = f.real();
    if (mode.pair) result.output_injection(mode.row + 1, mode.reading) = f.imag();
  }
  return result;
}

}  // namespace

void KklFamily::check(const Experiment& experiment, const ChannelCounts&) const {
  check_linear_latent(experiment);
}

/// Changes all time constants together, and sometimes the number of modes by one.
void KklFamily::vary(Experiment& experiment, Draws& draws) const {
  ObserverConfig& o = experiment.observer;
  const double faster = draws.one_of({0.5, 0.7, 1.0, 1.0, 1.4, 2.0});
  for (double& eigenvalue : o.eigenvalues) eigenvalue = rounded(faster * eigenvalue);
  for (auto& pair : o.pairs)
    for (double& part : pair) part = rounded(faster * part);
  for (double& clock : o.clocks_s) clock = rounded(clock / faster);
  constexpr double kBetweenModes = 2.5;  // factor between time constants, from experience
  switch (draws.below(4)) {
    case 0:  // adds a faster mode
      if (o.eigenvalues.empty() || o.eigenvalues.size() + 2 * o.pairs.size() >= 12) break;
      o.eigenvalues.push_back(rounded(kBetweenModes * *std::min_element(o.eigenvalues.begin(), o.eigenvalues.end())));
      break;
    case 1:  // removes a mode
      if (o.eigenvalues.size() > 1 && o.eigenvalues.size() + 2 * o.pairs.size() > 2)
        o.eigenvalues.erase(o.eigenvalues.begin() + static_cast<std::ptrdiff_t>(draws.below(o.eigenvalues.size())));
      break;
    default:
      break;
  }
}

void KklFamily::make(const Experiment& experiment, ObserverStructure& structure) const {
  add_modes(structure, experiment.observer);
  add_features(structure, experiment.observer);
}

std::vector<float> KklFamily::initial_dynamics(const ObserverStructure& structure, const Experiment&) const {
  return parameters_from_eigenvalues(structure.latent, structure.eigenvalues.data());
}

std::unique_ptr<OdeDynamics<float>> KklFamily::lanes(const ObserverStructure& structure) const {
  return std::make_unique<KklLanes<float>>(structure.latent, structure.eigenvalues, structure.readings);
}

std::unique_ptr<OdeDynamics<double>> KklFamily::lanes_in_double(const ObserverStructure& structure) const {
  return std::make_unique<KklLanes<double>>(structure.latent, structure.eigenvalues, structure.readings);
}

std::unique_ptr<LatentDynamics> KklFamily::latent_dynamics(const Experiment& experiment,
                                                           const ObserverStructure& structure,
                                                           const std::vector<double>& steps_s, int threads) const {
  if (experiment.training.gradient != LatentGradient::kAutomatic)
    return TrainableStructure::latent_dynamics(experiment, structure, steps_s, threads);
  return std::make_unique<LinearLatent>(structure.latent, structure.eigenvalues, steps_s,
                                        !experiment.observer.learn_eigenvalues);
}

codegen::Kkl KklFamily::kkl_of(const ObserverStructure& structure, const float* parameters,
                               const ObserverConfig& observer, codegen::Model& model) {
  codegen::Kkl kkl{.latent = linear_latent_of(structure, parameters, model),
                   .inverse_map = inverse_map_of(structure, parameters, model.nr())};
  // With these settings every feature is z - y and the steady gain is one, so a plant that rests at another output is
  // also in the domain.
  if (observer.features == FeatureSet::kLatentMinusOutput && structure.latent.injection == Injection::kUnitGain)
    for (int j = 0; j < model.ny(); ++j)
      if (model.outputs[static_cast<std::size_t>(j)].wrap <= 0.0) kkl.latent.relative_outputs.push_back(j);
  return kkl;
}

}  // namespace nlo::trainer

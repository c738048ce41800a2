// SPDX-License-Identifier: MIT
// D and F of z' = D z + F y as [observer] gives them, and the features of z for T*: for a KKL observer, and for the
// network of a general one starts as.
#pragma once

#include <complex>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Throws KeyError unless there is a D: eigenvalues or pairs, pairs within the left half plane, a stable step by `hold`
/// at the experiment's sample period, where only the logs' time stamps do not know it.
void check_linear_latent(const Experiment& experiment);

/// Throws KeyError when `hold` = rk4 diverges for one of the eigenvalues at this sample period (|A| >= 1), naming it
/// and the mends. Reading an experiment checks this itself unless only the log's time stamps know the period.
void check_latent_step(const ObserverConfig& observer, double sample_period_s);

/// Throws KeyError unless z starts at zero. `what` stands in the message: "the general observer".
void check_zero_start(const ObserverConfig& observer, const char* what);

/// D and F: identity Kronecker (eigenvalues), every output has modes of its own. With one set for all, the latent would
/// see only the sum of the outputs. Throws codegen::Error when there are no eigenvalues.
void add_modes(ObserverStructure& structure, const ObserverConfig& observer);

/// Adds the features of these modes to T*.
void add_features(ObserverStructure& structure, const ObserverConfig& observer);

/// Adds the products of the features with every clock. z forgets its start as exp(D t), so the best map from z to x
/// depends on the time since then: products let T* be another map for every time of the transient.
void add_clock_products(ObserverStructure& structure, ClockProductSet set);

/// Eigenvalue of a mode: the real one, or the pair's with positive imaginary part.
std::complex<double> eigenvalue_of(const Mode& mode, const std::vector<double>& eigenvalues);

}  // namespace nlo::trainer

// SPDX-License-Identifier: MIT
// D and F of z' = D z + F y from [observer], and the features of z that T* reads: for a KKL observer, and for the
// initial network of a general one.
#pragma once

#include <complex>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Throws KeyError unless [observer] gives a valid D: eigenvalues or pairs, pairs in the left half plane, and a stable
/// step by `hold` at the experiment's sample period. The step is not checked if only time stamps of logs determine the
/// period.
void check_linear_latent(const Experiment& experiment);

/// Throws KeyError if `hold` = rk4 diverges for one of the eigenvalues at this sample period (|A| >= 1). It names the
/// eigenvalue and the remedies. Reading an experiment checks this, unless only the time stamps of the log determine the
/// period.
void check_latent_step(const ObserverConfig& observer, double sample_period_s);

/// Throws KeyError unless z starts at zero. `what` is part of the message: "the general observer".
void check_zero_start(const ObserverConfig& observer, const char* what);

/// Adds D and F as a Kronecker product, identity x eigenvalues: every output has its own modes. If all outputs shared
/// modes, z would only contain their sum. Throws codegen::Error if there are no eigenvalues.
void add_modes(ObserverStructure& structure, const ObserverConfig& observer);

/// Adds the features of these modes to T*.
void add_features(ObserverStructure& structure, const ObserverConfig& observer);

/// Adds the products of the features with every clock. z forgets its start as exp(D t), so the best map from z to x
/// depends on the time since the start. With the products, T* can be another map at each time.
void add_clock_products(ObserverStructure& structure, ClockProductSet set);

/// Returns the eigenvalue of a mode: the real one, or that of the pair with positive imaginary part.
std::complex<double> eigenvalue_of(const Mode& mode, const std::vector<double>& eigenvalues);

}  // namespace nlo::trainer

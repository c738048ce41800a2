// SPDX-License-Identifier: MIT
// The transient of the latent filter: from z(0) = 0, z differs from T(x) by exp(D t) (z(0) - T(x(0))), so early pairs
// (z, x) teach T* relations that only hold after a reset. The supervised baseline (Ramos et al. 2020) keeps them out,
// by
//   drop      samples at t < t_c do not count
//   backward  each trajectory begins t_c earlier, in the plant's simulated past (plants/lead_in.h)
//   t_c = k / min |Re lambda|: the start has decayed to exp(-k)
#pragma once

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// min |Re lambda| of the initial eigenvalues of `observer`, clocks not counted [1/s]; 0 without any.
double decay_rate(const ObserverConfig& observer);

/// t_c [s] for the initial eigenvalues of `observer` (clocks not counted) and k = `factor`; infinite without any.
double transient_time_s(const ObserverConfig& observer, double factor);

/// Sets the weight of all samples to 0 that lie less than transient_s behind the first of their trajectory, and has
/// estimates begin behind them. Throws
/// codegen::Error naming the trajectory that has none left.
void drop_transient(Dataset& dataset, double transient_s);

}  // namespace nlo::trainer

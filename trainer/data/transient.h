// SPDX-License-Identifier: MIT
// The transient of the latent filter. From z(0) = 0, z differs from T(x) by exp(D t) (z(0) - T(x(0))), so early pairs
// (z, x) teach T* relations that hold only after a reset. The supervised baseline (Ramos et al. 2020) avoids them by
//   drop      samples at t < t_c do not count
//   backward  each trajectory begins t_c earlier, in the simulated past of the plant (plants/lead_in.h)
//   t_c = k / min |Re lambda|: the start has decayed to exp(-k)
#pragma once

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// Returns min |Re lambda| of the initial eigenvalues of `observer` except clocks [1/s]; 0 if there are none.
double decay_rate(const ObserverConfig& observer);

/// Returns t_c [s] for the initial eigenvalues of `observer` except clocks, and k = `factor`; infinite if there are
/// none.
double transient_time_s(const ObserverConfig& observer, double factor);

/// Sets the weight of all samples within transient_s after the first sample of their trajectory to 0. Estimates begin
/// after these samples. Throws codegen::Error with the name of a trajectory that has no sample left.
void drop_transient(Dataset& dataset, double transient_s);

}  // namespace nlo::trainer

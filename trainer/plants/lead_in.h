// SPDX-License-Identifier: MIT
// A lead-in: the past of the plant, simulated backwards from x(0). A filter that starts there has forgotten its start
// at t = 0, so that z(0) = T(x(0)), and every later pair (z, x) belongs to the map T (Ramos et al. 2020).
#pragma once

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// Puts t_c = transient_s (rounded up to whole samples) before each trajectory, by RK4 with a negative step. These
/// samples have t < 0 and weight 0.
///   dataset  simulated without inputs, from t = 0, at its sample period
///   factor   k of t_c = k / min |Re lambda
///
/// Throws codegen::Error with plant, x(0), time and remedy if the backward flow overflows (|x| > 1e9 or NaN), or if it
/// grows by more than exp(k), which is faster than the filter forgets.
void add_lead_in(const Plant& plant, double transient_s, double factor, Dataset& dataset);

/// Applies [training] transient to a simulated training or validation set: keep, drop (data/transient.h) or backward.
void keep_out_transient(const Experiment& experiment, const Plant& plant, Dataset& dataset);

}  // namespace nlo::trainer

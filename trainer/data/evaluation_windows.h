// SPDX-License-Identifier: MIT
// Windows of a run over which errors are averaged: those of [evaluation], or else a transient and a settled window that
// follow from the observer's time constants. So they suit fast and slow plants.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// A list of windows that begins with "all", the whole run.
using EvaluationWindows = std::vector<EvaluationWindow>;

/// Returns the list with "all" alone.
EvaluationWindows whole_run();

/// Returns "all", then the windows of `evaluation`. Without any: "transient", t < t_c, and "settled", t >= t_c,
///   t_c = min(5 / decay_rate, horizon / 2)   z(0) has decayed to exp(-5)
///   t_c = horizon / 5                        if no rate is known: decay_rate = 0
/// rounded to two digits. The rate comes from the experiment, not from the trained eigenvalues, so that all models of
/// one experiment have the same windows.
///   decay_rate  min |Re lambda| over the initial eigenvalues of D except clocks [1/s]; 0 for structures without D
EvaluationWindows evaluation_windows(const EvaluationConfig& evaluation, double decay_rate, double horizon_s);

/// Returns the first window after "all" that lasts to the end of a run. It is used to judge an observer after its
/// transient. Returns 0, "all", if there is none.
std::size_t settled_window(const EvaluationWindows& windows);

/// Returns the start of settled_window() [s].
double settled_from_s(const EvaluationWindows& windows);

/// Returns the time over which errors are averaged for the settling time: the configured time; otherwise a tenth of the
/// time before the settled window; otherwise a fiftieth of the horizon.
double settling_window_s(const EvaluationConfig& evaluation, const EvaluationWindows& windows, double horizon_s);

/// Returns "all", "settled (t >= 10 s)", "early (0.5-5 s)".
std::string window_text(const EvaluationWindow& window);

}  // namespace nlo::trainer

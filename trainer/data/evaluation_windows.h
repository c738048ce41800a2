// SPDX-License-Identifier: MIT
// The stretches of a run that errors are told for: as [evaluation] says, else a transient and a settled one that fit
// the plant, be it a motor or an epidemic.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// A list of windows that begins with "all", the whole run.
using EvaluationWindows = std::vector<EvaluationWindow>;

/// "all" alone.
EvaluationWindows whole_run();

/// "all", then the windows of `evaluation`. Without any: "transient", t < t_c, and "settled", t >= t_c,
///   t_c = min(5 / decay_rate, horizon / 2)   z(0) has decayed to exp(-5)
///   t_c = horizon / 5                        where no rate is known: decay_rate = 0
/// rounded to two digits. The rate comes from the experiment, not from the trained eigenvalues, so that models
/// of one experiment are judged alike.
///   decay_rate  min |Re lambda| over the initial eigenvalues of D that are no clocks [1/s]; 0 for structures without D
EvaluationWindows evaluation_windows(const EvaluationConfig& evaluation, double decay_rate, double horizon_s);

/// The first window after "all" that lasts to the end of a run. It judges an observer after its transient. 0, "all", if
/// there is none.
std::size_t settled_window(const EvaluationWindows& windows);

/// The start of that window [s].
double settled_from_s(const EvaluationWindows& windows);

/// How long errors are averaged before the settling time is read: as configured, else a tenth of the time before the
/// settled window, else a fiftieth of the horizon.
double settling_window_s(const EvaluationConfig& evaluation, const EvaluationWindows& windows, double horizon_s);

/// "all", "settled (t >= 10 s)", "early (0.5-5 s)".
std::string window_text(const EvaluationWindow& window);

}  // namespace nlo::trainer

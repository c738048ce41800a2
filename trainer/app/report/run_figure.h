// SPDX-License-Identifier: MIT
// Runs of a test as plots: truth, estimate and measurement over time, with its error below each state.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "trainer/app/report/gnuplot.h"
#include "trainer/app/report/html.h"
#include "trainer/judge/evaluation/evaluate.h"

namespace nlo::trainer {

/// Draws a run from t0 to t1 [s]. Each state has a panel, and below it another one with the error x_hat - x on its own
/// scale (of an angle the shorter way round). Then there is a panel for each output that is not a state itself, and one
/// for each input if `inputs` names those of the run. Times at which the truth is masked or z is outside of the
/// training domain are shaded. A few samples far outside do not determine a scale; the legend states them.
Figure run_figure(const EvaluatedRun& run, const std::vector<Channel>& states, const std::vector<Channel>& outputs,
                  double t0, double t1, const std::vector<Channel>& inputs = {});

/// Draws the whole run without panels of outputs that are not states. Its time axis names the run and its errors.
Figure run_picture(const EvaluatedRun& run, const std::vector<Channel>& states, const std::vector<Channel>& outputs);

/// Returns the root mean square error of each state over the run's scored samples, with names and units: "x1 0.12 m, x2
/// 0.3 m/s".
std::string run_errors(const EvaluatedRun& run, const std::vector<Channel>& states);

struct ShownRuns {
  const std::vector<EvaluatedRun>& runs;
  const std::vector<Channel>& states;
  const std::vector<Channel>& outputs;
  const std::vector<Channel>& inputs;
  std::string condition;  ///< "with N(0, 0.5)"; may be empty
  std::size_t of = 0;     ///< number of runs in the test
};

/// Adds a figure for each run, and one for the start of the first. Captions say which runs these are.
void add_runs(Page& page, const ShownRuns& shown);

}  // namespace nlo::trainer

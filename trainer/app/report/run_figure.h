// SPDX-License-Identifier: MIT
// Runs of a test as plots: truth, estimate and measurement over time, under each state its error.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "trainer/app/report/gnuplot.h"
#include "trainer/app/report/html.h"
#include "trainer/judge/evaluation/evaluate.h"

namespace nlo::trainer {

/// From t0 to t1 [s]: a panel per state and below it the error x_hat - x, angles the short way round, on a scale of its
/// own; then a panel per output that is not a state itself, and one per input where `inputs` names those of the run.
/// Shaded where the truth is masked and where z is outside of the training domain. A few samples far out of the rest do
/// not set a scale: the legend says how far they go.
Figure run_figure(const EvaluatedRun& run, const std::vector<Channel>& states, const std::vector<Channel>& outputs,
                  double t0, double t1, const std::vector<Channel>& inputs = {});

/// The whole run without the panels of outputs that are no states; its time axis names the run and its errors.
Figure run_picture(const EvaluatedRun& run, const std::vector<Channel>& states, const std::vector<Channel>& outputs);

/// Root mean square error of each state over the run's scored samples, with names and units: "x1 0.12 m, x2 0.3 m/s".
std::string run_errors(const EvaluatedRun& run, const std::vector<Channel>& states);

struct ShownRuns {
  const std::vector<EvaluatedRun>& runs;
  const std::vector<Channel>& states;
  const std::vector<Channel>& outputs;
  const std::vector<Channel>& inputs;
  std::string condition;  ///< "with N(0, 0.5)"; may be empty
  std::size_t of = 0;     ///< how many runs the test has
};

/// A figure for each run, and one for the start of the first; captions say which runs these are.
void add_runs(Page& page, const ShownRuns& shown);

}  // namespace nlo::trainer

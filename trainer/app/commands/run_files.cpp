// SPDX-License-Identifier: MIT
#include "trainer/app/commands/run_files.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/model/model.h"
#include "trainer/app/commands/output_directory.h"
#include "trainer/app/report/run_figure.h"
#include "trainer/app/report/svg_text.h"
#include "trainer/base/number_text.h"
#include "trainer/base/printable.h"
#include "trainer/data/angle.h"
#include "trainer/judge/evaluation/evaluate.h"

namespace nlo::trainer {
namespace {

/// Returns CSV with a heading and a row per sample:
///   time              of the run [s]
///   step_s            dt of step(); 0: the sample period
///   OUTPUT...         as measured, angles within half a turn of 0; nan if missing
///   INPUT...          as given
///   STATE_estimate... x_hat; an angle may have any turn
///   in_domain         1 if z is in the training domain
///   STATE_truth...    angles within half a turn of 0; nan if masked or unknown
/// `model` has estimated `run`. `uniform_steps`: each step is one sample period.
///   unscored  names of states without truth in the run; if there are any, run.all_estimates has all estimates
std::string estimates_csv(const codegen::Model& model, const EvaluatedRun& run, bool uniform_steps,
                          const std::vector<std::string>& unscored) {
  std::string text = "time,step_s";
  for (const Channel& output : model.outputs) text += "," + output.name;
  for (const Channel& input : model.inputs) text += "," + input.name;
  for (const Channel& state : model.states) text += "," + state.name + "_estimate";
  text += ",in_domain";
  for (const Channel& state : model.states) text += "," + state.name + "_truth";
  text += "\n";
  // Enough digits to distinguish all floats.
  const auto append = [&text](double value) { text += fmt::format(",{:.9g}", value); };
  const auto as_shown = [](double value, const Channel& channel) {
    return channel.wrap > 0.0 ? wrap_difference(value, channel.wrap) : value;
  };
  const Trajectory& truth = run.truth;
  const Eigen::MatrixXd& estimate = run.all_estimates.size() > 0 ? run.all_estimates : run.estimate;
  for (Eigen::Index k = 0; k < truth.samples(); ++k) {
    text += shortest_text(truth.time_s[k]);
    append(uniform_steps || k == 0 ? 0.0 : truth.time_s[k] - truth.time_s[k - 1]);
    for (Eigen::Index j = 0; j < run.measured.rows(); ++j)
      append(as_shown(run.measured(j, k), model.outputs[static_cast<std::size_t>(j)]));
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(model.inputs.size()); ++i)
      append(truth.inputs.size() > 0 ? truth.inputs(i, k) : 0.0);
    for (Eigen::Index i = 0; i < estimate.rows(); ++i) append(estimate(i, k));
    append(run.outside.size() > 0 && run.outside[k] > 0.0 ? 0.0 : 1.0);
    Eigen::Index row = 0;
    for (const Channel& state : model.states) {
      const bool is_known = std::find(unscored.begin(), unscored.end(), state.name) == unscored.end();
      append(is_known && truth.weight[k] > 0.0 ? as_shown(truth.states(row, k), state)
                                               : std::numeric_limits<double>::quiet_NaN());
      row += is_known ? 1 : 0;
    }
    text += "\n";
  }
  return text;
}

void check(const char* option, const std::string& file, const std::string& ending) {
  if (file.empty()) return;
  if (!file.ends_with(ending)) throw codegen::Error(fmt::format("{} {}: write FILE{}", option, file, ending));
  check_output_file(file);
}

void write(const std::string& file, const std::string& text, const EvaluatedRun& run) {
  write_output_file(file, text);
  fmt::print(stderr, "{}\n", printable(file + ": " + run.truth.source));
}

}  // namespace

void check_run_files(const RunFiles& files) {
  check("--figure", files.figure, ".svg");
  check("--estimates", files.estimates, ".csv");
}

void write_run_files(const RunFiles& files, const codegen::Model& model, const LogEvaluation& evaluation,
                     bool uniform_steps) {
  const std::vector<EvaluatedRun>& runs = evaluation.examples;
  const auto count = static_cast<int>(runs.size());
  const std::size_t all = evaluation.entries.front().metrics.runs;
  if (files.any() && runs.size() < all)
    fmt::print(stderr, "{} of the {} runs are written: the first, the best, the worst, and some of the others\n", count,
               all);
  if (!files.figure.empty()) {
    std::vector<Figure> figures;
    for (const EvaluatedRun& run : runs) {
      figures.push_back(run_picture(run, evaluation.states, evaluation.outputs));
      if (figures.back().panels.empty())
        throw codegen::Error(
            fmt::format("--figure: {} has only one sample, so there is no figure; use a longer log", run.truth.source));
    }
    const Drawing drawing = draw(figures);
    if (!drawing.failure.empty())
      throw codegen::Error(fmt::format("--figure: {}. Install gnuplot (Debian: gnuplot-nox)", drawing.failure));
    for (int i = 0; i < count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      write(numbered_file(files.figure, i, count), standalone_svg(drawing.svgs[at]), runs[at]);
    }
  }
  for (int i = 0; i < count && !files.estimates.empty(); ++i) {
    const EvaluatedRun& run = runs[static_cast<std::size_t>(i)];
    write(numbered_file(files.estimates, i, count),
          estimates_csv(model, run, uniform_steps, evaluation.unscored_states), run);
  }
}

std::string numbered_file(const std::string& file, int index, int count) {
  if (count == 1) return file;
  const auto slash = file.rfind('/'), dot = file.rfind('.');
  const bool has_extension = dot != std::string::npos && (slash == std::string::npos || dot > slash + 1) && dot > 0;
  const std::string stem = has_extension ? file.substr(0, dot) : file;
  return fmt::format("{}_{}{}", stem, index + 1, has_extension ? file.substr(dot) : "");
}

}  // namespace nlo::trainer

// SPDX-License-Identifier: MIT
#include "trainer/commands/run_files.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <cstdio>

#include "codegen/base/error.h"
#include "trainer/base/printable.h"
#include "trainer/commands/output_directory.h"
#include "trainer/evaluation/estimates_csv.h"
#include "trainer/report/run_figure.h"
#include "trainer/report/svg_text.h"

namespace nlo::trainer {
namespace {

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
    fmt::print(stderr, "{} of the {} runs are written: the first, the best, the worst and others between\n", count,
               all);
  if (!files.figure.empty()) {
    std::vector<Figure> figures;
    for (const EvaluatedRun& run : runs) {
      figures.push_back(run_picture(run, evaluation.states, evaluation.outputs));
      if (figures.back().panels.empty())
        throw codegen::Error(fmt::format("--figure: {} has one sample; there is nothing to draw", run.truth.source));
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

// SPDX-License-Identifier: MIT
#include "trainer/app/report/report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "codegen/base/file.h"
#include "trainer/app/report/figures.h"
#include "trainer/app/report/html.h"
#include "trainer/app/report/report_summary.h"
#include "trainer/app/report/run_figure.h"
#include "trainer/base/number_text.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/judge/evaluation/estimator_words.h"
#include "trainer/judge/evaluation/evaluation_text.h"

namespace nlo::trainer {
namespace {

/// Returns true if `holds` is true for any evaluation of the test.
template <class Holds>
bool any(const std::vector<StudyRow>& rows, const Holds& holds) {
  return std::ranges::any_of(rows, [&](const StudyRow& row) {
    return std::ranges::any_of(row.cells, [&](const StudyCell& cell) { return holds(cell.first()); });
  });
}

/// Explains the columns and the rows of the table.
std::string plant_table_notes(const std::vector<StudyRow>& rows) {
  std::string text =
      "norm: root mean square of |x − x̂| over runs and samples, transient included. nrmse: norm divided by the root "
      "mean square of |x|.";
  if (rows.front().observer().first().metrics.normalised)
    text += " The states' units differ: each is divided by its standard deviation.";
  if (any(rows, [](const Evaluation& e) { return e.metrics.settled.has_value(); }))
    text +=
        " settled: norm after the transient. Settling time: the time after which the error, averaged over the runs and "
        "a short window, stays within 1.5 times its settled value.";
  text += " Initial states are new to the observer.";
  if (any(rows, [](const Evaluation& e) { return !e.noise.none(); }))
    text += " One independent draw of noise per sample.";
  std::vector<const EstimatorWords*> said;
  for (const StudyRow& row : rows)
    for (const StudyCell& cell : row.cells)
      if (const EstimatorWords* words = estimator_words(cell.first().estimator);
          words != nullptr && std::ranges::find(said, words) == said.end()) {
        said.push_back(words);
        text += fmt::format(" {}: {}{}.", words->name, words->meaning,
                            words->knows_plant ? " that knows plant and noise exactly" : "");
      }
  return text;
}

std::string plant_table(const std::vector<StudyRow>& rows) {
  return html_table(evaluation_table(rows, true)) + fmt::format("<p class=\"soft\">{}</p>\n", plant_table_notes(rows));
}

std::string log_tables(const LogEvaluation& logs, const std::vector<std::string>& derived_states) {
  std::string html = html_table(log_table(logs.entries));
  if (logs.entries.size() > 1)
    html += fmt::format("<p class=\"soft\">Alternatives are fitted on {}.</p>\n", escaped(logs.baselines_fitted_on));
  if (!derived_states.empty())
    html += fmt::format(
        "<p class=\"soft\">Truth of {}: the slope of a logged column, smoothed forwards and backwards.</p>\n",
        escaped(fmt::format("{}", fmt::join(derived_states, ", "))));
  if (logs.unscored.share > 0.0)
    html += fmt::format("<p class=\"soft\">Unscored: {} of the samples, {}.</p>\n", percent(logs.unscored.share),
                        escaped(logs.unscored.where));
  html += fmt::format(
      "<p class=\"soft\">z is in the training domain at {} of the samples, and at the first sample of {} of {} "
      "runs.</p>\n",
      percent(logs.domain.share()), logs.domain.first_inside, logs.domain.runs);
  for (const std::string& text : logs.notes) html += note(text);
  const Table files = file_table(logs);
  return files.rows.empty() ? html : html + html_table(files);
}

std::string clock_table(const LogReport& report) {
  Table table{{"log", "samples", "duration [s]", "step, median [ms]", "1 % [ms]", "99 % [ms]", "longest [ms]", "gaps"}};
  for (const TimeStampReport& file : report.files)
    table.add_row({named(file), std::to_string(file.samples), fixed(file.duration_s, 1),
                   significant(1e3 * file.median_s, 4), significant(1e3 * file.p01_s, 4),
                   significant(1e3 * file.p99_s, 4), significant(1e3 * file.max_s, 4), std::to_string(file.gaps)});
  std::string html = html_table(table);
  for (const std::string& text : report.notes) html += note(text);
  return html;
}

std::string loop_table(const ControlLoopResult& r) {
  Table table{{"", "p50", "p99", "p99.9", "max"}};
  for (const auto& [name, q] :
       {std::pair{"step + estimate", r.step_and_estimate}, {"woken after its deadline", r.wake_up_lateness}})
    table.add_row({name, nanoseconds(q.p50), nanoseconds(q.p99), nanoseconds(q.p99_9), nanoseconds(q.max)});
  return fmt::format(
             "<p>The exported header in a periodic thread at {} Hz, with measurement noise N(0, {}): {} ticks, {} "
             "missed "
             "deadlines, estimation error {} ({} once settled). {} measurements were clamped or held, {} estimates lay "
             "outside the training domain. {}; {}.</p>\n",
             shortest_text(r.rate_hz), shortest_text(r.noise_std), r.ticks, r.missed_deadlines,
             significant(r.rms_error), significant(r.settled_rms_error), r.faults, r.outside_domain,
             r.real_time_priority ? "Real-time priority" : "Ordinary scheduling (real-time priority was not permitted)",
             r.memory_locked ? "memory locked" : "memory not locked") +
         html_table(table);
}

std::string facts_list(const std::vector<std::pair<std::string, std::string>>& facts) {
  std::string list, blocks;
  for (const auto& [name, value] : facts) {
    if (value.find('\n') == value.npos)
      list += fmt::format("<dt>{}</dt><dd>{}</dd>\n", escaped(name), escaped(value));
    else
      blocks += fmt::format("<p class=\"soft\">{}</p>\n<pre>{}</pre>\n", escaped(name), escaped(value));
  }
  return fmt::format("<dl>\n{}</dl>\n{}", list, blocks);
}

void add_plant_sections(Page& page, const ReportData& data) {
  const Evaluation& main = main_row(data.rows)->observer().first();
  page.heading("Errors");
  page.text(plant_table(data.rows));
  for (const StudyRow& row : data.rows)
    for (const std::string& text : study_notes(row)) page.text(note(text));
  page.figure(error_figure(data.rows));
  page.heading("Runs of the test set");
  add_runs(page, {main.examples, main.states, main.outputs, data.inputs,
                  fmt::format("with {}", noise_title(main.noise)), static_cast<std::size_t>(main.trajectories)});
}

void add_log_sections(Page& page, const ReportData& data) {
  const LogEvaluation& logs = *data.logs;
  page.heading(logs.split == "training"     ? "Errors on the training logs"
               : logs.split == "validation" ? "Errors on the validation logs"
                                            : "Errors on logs that were not trained on");
  page.text(log_tables(logs, data.derived_states));
  page.heading(logs.split.empty() ? "The logs" : fmt::format("The {} logs", logs.split));
  add_runs(page, {logs.examples, logs.states, logs.outputs, data.inputs,
                  logs.noise.none() ? "" : fmt::format("with {} added", noise_title(logs.noise)),
                  logs.entries.front().metrics.runs});
}

}  // namespace

ReportData report_of(const codegen::Model& model, const std::string& directory) {
  namespace fs = std::filesystem;
  ReportData data;
  data.title = model.name;
  data.facts = model.provenance;
  data.inputs = codegen::inputs(model);
  const fs::path run = directory.empty() ? "." : directory;
  std::error_code ignored;
  if (fs::exists(run / "metrics.csv", ignored)) data.training = read_training_curves((run / "metrics.csv").string());
  if (fs::exists(run / "control_loop.json", ignored)) {
    const auto model_time = fs::last_write_time(run / "model.json", ignored);
    if (ignored || fs::last_write_time(run / "control_loop.json", ignored) >= model_time)
      data.control_loop = read_control_loop((run / "control_loop.json").string());
  }
  return data;
}

std::string render_report(const ReportData& data, const std::string& gnuplot) {
  Page page;
  page.text(fmt::format(
      "<h1>{}</h1>\n<p class=\"soft\">A learned Luenberger observer: what it was trained on and how well it "
      "estimates the state.</p>\n",
      escaped(data.title)));
  if (!data.warning.empty()) page.text(alarm(data.warning));
  const StudyRow* row = main_row(data.rows);
  if (row != nullptr) page.text(fmt::format("<p class=\"summary\">{}</p>\n", escaped(plant_summary(*row))));
  if (data.logs) page.text(fmt::format("<p class=\"summary\">{}</p>\n", escaped(log_summary(*data.logs))));
  page.text(tiles(data));
  if (row != nullptr) add_plant_sections(page, data);
  if (data.logs) add_log_sections(page, data);
  if (data.control_loop) {
    page.heading("In a control loop");
    page.text(loop_table(*data.control_loop));
    page.figure(latency_figure(*data.control_loop));
  }
  if (data.training && data.training->step.size() > 0) {
    page.heading("Training");
    page.figure(training_figure(*data.training));
    if (!data.training->eigenvalues.empty()) {
      page.figure(eigenvalue_figure(*data.training));
      page.figure(eigenvalue_map(*data.training));
    }
  }
  if (data.log_clock) {
    page.heading("The logs' clock");
    page.text(clock_table(*data.log_clock));
  }
  if (!data.facts.empty()) {
    page.heading("How this model was made");
    page.text(facts_list(data.facts));
  }
  return html_page(fmt::format("{} - observer report", data.title), page.html(gnuplot));
}

void write_report(const ReportData& data, const std::string& path) {
  codegen::write_file_atomically(path, render_report(data));
}

}  // namespace nlo::trainer

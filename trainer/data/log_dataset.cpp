// SPDX-License-Identifier: MIT
#include "trainer/data/log_dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/data/impossible_values.h"
#include "trainer/data/log_checks.h"
#include "trainer/data/log_clock.h"
#include "trainer/data/log_file.h"
#include "trainer/data/log_files.h"
#include "trainer/data/log_jumps.h"
#include "trainer/data/log_outliers.h"
#include "trainer/data/log_schema.h"
#include "trainer/data/logged_velocity.h"
#include "trainer/data/run_loader.h"

namespace nlo::trainer {
namespace {

using codegen::Error;
using Eigen::Index;

bool is_under(const std::vector<std::string>& headings, const LogColumn& column) {
  return std::ranges::find(headings, column.heading) != headings.end();
}

/// Loads the runs of a log. If gaps split the log, runs that are too short are dropped with a note. Throws Error if a
/// log without a gap is too short, or if no run is left. `impossible`: headings of columns whose steps are not checked.
void load_runs(const LogConfig& config, const LogSchema& schema, const LogFile& log, const std::vector<LogRun>& runs,
               const std::vector<std::string>& impossible, Dataset& data, LogReport& report) {
  std::string first_dropped, why;
  std::size_t dropped = 0;
  bool nominal = true;
  std::vector<Eigen::VectorXd> times_s;
  std::vector<SuspiciousSteps> steps;
  for (const LogRun& run : runs) {
    try {
      data.trajectories.push_back(load_run(config, schema, data.sample_period_s, log, run, steps));
    } catch (const Error& error) {
      if (runs.size() == 1) throw Error(fmt::format("{}: {}", log.path, error.what()));
      if (why.empty()) why = error.what();
      if (dropped++ == 0) first_dropped = run.source;
      continue;
    }
    nominal = nominal && run.grid.regular && run.grid.complete && has_period(run.grid, data.sample_period_s);
    times_s.push_back(run.time_s);
  }
  if (times_s.empty())
    throw Error(
        fmt::format("{}: none of its runs between gaps can be used; the first cannot, because {}: raise [log] "
                    "max_gap_s, or use a longer log",
                    log.path, why.empty() ? "it has one sample, or an output or input without a value" : why));
  data.uniform = data.uniform && nominal;
  report.files.push_back(report_time_stamps(log.name, times_s, data.sample_period_s));
  report.files.back().nominal = nominal;
  if (dropped > 0)
    note_once(report.notes, fmt::format("{}: {} of its {} runs cannot be used and are dropped, the first is {} ({}); "
                                        "raise [log] max_gap_s to keep the log whole",
                                        log.name, dropped, runs.size(), first_dropped, why));
  std::erase_if(steps, [&](const SuspiciousSteps& each) { return is_under(impossible, *each.column); });
  note_suspicious_steps(steps, log.name, report.notes);
}

/// Thins all runs: each becomes `phases` runs, which begin at its first, second, ... row.
void thin(Index every, Index phases, Dataset& data) {
  if (every == 1) return;
  std::vector<Trajectory> thinned_runs;
  for (const Trajectory& run : data.trajectories)
    for (Index first = 0; first < phases; ++first) {
      if (run.samples() < first + every + 1)
        throw Error(fmt::format(
            "{}: has {} rows, of which every = {} leaves fewer than two samples: use a longer log, or a smaller number",
            run.source, run.samples(), every));
      thinned_runs.push_back(run.from(first, every));
      if (first > 0) thinned_runs.back().source = fmt::format("{} from its row {}", run.source, first + 1);
    }
  data.trajectories = std::move(thinned_runs);
  data.sample_period_s *= static_cast<double>(every);
}

/// Returns the schema without the columns under `headings`, for further checks. These columns have impossible values,
/// which would cause misleading notes.
LogSchema without(LogSchema schema, const std::vector<std::string>& headings) {
  for (auto* columns : {&schema.outputs, &schema.states, &schema.inputs})
    std::erase_if(*columns, [&](const LogColumn& column) { return is_under(headings, column); });
  return schema;
}

/// Throws Error if an output is declared slow but is not.
void check_periods(const LogSchema& schema, double sample_period_s) {
  for (const LogColumn& output : schema.outputs)
    if (output.period_s > 0.0 && output.period_s < codegen::kShortestOutputPeriod * sample_period_s)
      throw Error(fmt::format(
          "[[log.columns]] \"{}\": period_s = {} is not longer than the sample period, {:.6g} s: remove it, "
          "or give the seconds between two values of this sensor",
          output.name, output.period_s, sample_period_s));
}

/// Loads files that exist, and adds findings to `report`. `decides`: the notes on columns come from these logs.
/// `all_phases`: with every = n, each log becomes n runs, so that no row is lost.
Dataset load(LogConfig config, const LogSchema& schema, const std::vector<std::string>& paths, bool decides,
             bool all_phases, LogReport& report) {
  for (const ColumnConfig& column : config.columns)
    if (column.find_delay)
      throw Error(
          fmt::format("[[log.columns]] \"{}\": delay_s = \"estimate\" is for nlo train and nlo crossvalidate; "
                      "write the delay in seconds here",
                      column.name));
  config.sample_period_s /= config.every;  // from here on it is the period of the rows
  std::vector<LogFile> logs;
  for (const std::string& path : paths) logs.push_back(read_log(path, schema, config.sample_period_s));
  Dataset data;
  data.outputs = schema.output_channels;
  data.states = schema.state_channels;
  data.inputs = schema.input_channels;
  data.reads_inputs = !schema.input_channels.empty();
  for (Index channel = 0; const LogColumn& output : schema.outputs) {
    if (output.sincos) data.output_angles.push_back({channel, output.wrap});
    channel += output.channels();
  }
  if (logs.empty()) {
    data.sample_period_s = config.sample_period_s * config.every;
    return data;
  }
  const LogRuns runs = split_logs(config, logs, report.notes);
  data.sample_period_s = report.sample_period_s = nominal_period(config, runs);
  const std::vector<std::string> impossible = note_impossible_values(schema, logs, report.notes);
  const LogSchema possible = without(schema, impossible);
  const std::string doubt = time_unit_doubt(schema, config, logs);
  if (!doubt.empty()) report.notes.push_back(doubt);
  for (std::size_t i = 0; i < logs.size(); ++i) {
    if (!runs[i].empty()) check_period(logs[i], runs[i].front(), data.sample_period_s, report.notes);
    try {
      load_runs(config, schema, logs[i], runs[i], impossible, data, report);
    } catch (const Error& error) {
      if (doubt.empty()) throw;
      throw Error(fmt::format("{}; {}", error.what(), doubt));
    }
    report.contents.push_back(content_of(logs[i], listed_headings(schema)));
  }
  count_empty_cells(schema, logs, report.empty_cells);
  note_jumps(possible, logs, runs, report.notes);
  note_outliers(possible, logs, report.notes);
  if (decides) {
    note_suspicious_columns(possible, logs, report.notes);
    note_logged_velocities(possible, config.velocity_filter, logs, runs, data.sample_period_s, report.notes);
  }
  // If one run is irregular, all runs are treated as irregular, because their steps share a table.
  if (!data.uniform)
    for (TimeStampReport& file : report.files) file.nominal = false;
  thin(config.every, all_phases ? config.every : 1, data);
  check_periods(schema, data.sample_period_s);
  data.compute_outputs();
  return data;
}

}  // namespace

Dataset load_logs(const LogConfig& config, const std::string& directory, const std::vector<std::string>& files,
                  LogReport* report) {
  const std::vector<std::string> paths = expand_files(directory, files);
  if (paths.empty()) throw Error("no log is named: expected at least one file or glob");
  LogReport found;
  Dataset data = load(config, resolve_columns(config), paths, true, false, found);
  note_empty_cells(found.empty_cells, found.notes);
  found.data_hash = content_hash(paths);
  if (report != nullptr) *report = std::move(found);
  return data;
}

LogSplits load_log_splits(const LogConfig& config, const std::string& directory,
                          const std::vector<std::string>& mirrored) {
  const LogSchema schema = resolve_columns(config);
  const SplitFiles files = expand_splits(config, directory);
  LogSplits splits;
  splits.train = load(config, schema, files.train, true, true, splits.report);
  const std::vector<LogContent> trained = splits.report.contents;
  splits.train.mirror = mirror_of(mirrored, splits.train.readings(), splits.train.states);
  splits.remembered = remember(trained, splits.train);

  LogConfig on_training_clock = config;
  on_training_clock.sample_period_s = splits.train.sample_period_s;
  const auto load_other = [&](const std::vector<std::string>& paths, const char* name) {
    LogReport found;
    found.empty_cells = std::move(splits.report.empty_cells);
    Dataset data = load(on_training_clock, schema, paths, false, false, found);
    splits.report.empty_cells = std::move(found.empty_cells);
    note_shared_rows(trained, found.contents, name, found.notes);
    note_outputs_beyond(splits.remembered, data, found.notes);
    for (const std::string& text : found.notes) note_once(splits.report.notes, text);
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    append(splits.report.files, found.files);
    append(splits.report.contents, found.contents);
    return data;
  };
  splits.validation = load_other(files.validation, "validation");
  splits.test = load_other(files.test, "test");
  note_empty_cells(splits.report.empty_cells, splits.report.notes);

  std::vector<std::string> all = files.train;
  all.insert(all.end(), files.validation.begin(), files.validation.end());
  all.insert(all.end(), files.test.begin(), files.test.end());
  splits.report.data_hash = content_hash(all);
  return splits;
}

}  // namespace nlo::trainer

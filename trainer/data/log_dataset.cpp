// SPDX-License-Identifier: MIT
#include "trainer/data/log_dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/data/angle.h"
#include "trainer/data/log_checks.h"
#include "trainer/data/log_delays.h"
#include "trainer/data/log_file.h"
#include "trainer/data/log_files.h"
#include "trainer/data/log_schema.h"
#include "trainer/data/logged_velocity.h"
#include "trainer/data/zero_phase_filter.h"

namespace nlo::trainer {
namespace {

using codegen::Error;
using Eigen::Index;
using Eigen::VectorXd;

constexpr double kGapPeriods = 10.0;  // of max_gap_s = 0

/// A run as training reads it.
class Loader {
 public:
  /// `steps`: adds what is read.
  Loader(const LogConfig& config, const LogSchema& schema, double sample_period_s, std::vector<SuspiciousSteps>& steps)
      : config_(config), schema_(schema), sample_period_s_(sample_period_s), steps_(steps) {
    filtered_ = std::any_of(schema.states.begin(), schema.states.end(), [](const auto& s) { return s.derivative; });
  }

  Trajectory load(const LogFile& log, const LogRun& run) const {
    Trajectory result;
    result.source = run.source;
    result.log = log.path;
    result.time_s = time_of(run);
    result.outputs = channels(log, run, result.time_s, schema_.outputs, schema_.output_channels.size());
    result.states = channels(log, run, result.time_s, schema_.states, schema_.state_channels.size());
    if (!schema_.inputs.empty())
      result.inputs = channels(log, run, result.time_s, schema_.inputs, schema_.input_channels.size());
    result.weight = weights(result.time_s);
    if (!log.empty.empty()) {
      result.missing = missing_outputs(log, run);
      mask_empty_states(log, run, result.time_s, result.weight);
      if (result.weight.sum() == 0.0 && weights(result.time_s).sum() > 0.0)
        throw Error(
            "no row has a value of every state (away from the ends, where a state is a velocity): use a log with the "
            "truth in it");
    }
    if (result.weight.sum() == 0.0)
      throw Error(fmt::format("{:.3g} s long, all of it within mask_edges_s = {} s of its ends: use a longer log",
                              result.time_s[run.rows - 1], config_.velocity_filter.mask_edges_s));
    return result;
  }

 private:
  /// Rounded stamps of a moving angle are noise in its velocity (1 ms at 10 rad/s: 10 mrad): the grid is the better
  /// clock. Stamps that jitter beyond their rounding are taken at their word.
  VectorXd time_of(const LogRun& run) const {
    if (!run.grid.rounded) return run.time_s;
    return run.grid.counts * (has_period(run.grid, sample_period_s_) ? sample_period_s_ : run.grid.period_s);
  }

  /// `truth`: empty cells are on straight lines, not held.
  VectorXd read(const LogFile& log, const LogRun& run, const LogColumn& column, const VectorXd& time_s,
                bool truth) const {
    VectorXd values = log.values(column).segment(run.first, run.rows);
    if (column.wrap > 0.0) values = unwrap(values, column.wrap);
    if (truth) draw_lines(empty_rows(log, run, column.heading), time_s, values);
    count_suspicious_steps(column, values, steps_);
    return values;
  }

  Eigen::MatrixXd channels(const LogFile& log, const LogRun& run, const VectorXd& time_s,
                           const std::vector<LogColumn>& columns, std::size_t count) const {
    Eigen::MatrixXd values = Eigen::MatrixXd::Zero(static_cast<Index>(count), run.rows);  // computed ones come later
    Index channel = 0;
    for (const LogColumn& column : columns) {
      const VectorXd raw = read(log, run, column, time_s, &columns == &schema_.states);
      if (column.delay_s > 0.0) {
        values.row(channel++) = delayed(time_s, raw, column.delay_s).transpose();
      } else if (column.derivative) {
        const VectorXd velocity = zero_phase_velocity(config_.velocity_filter, time_s, raw, sample_period_s_);
        values.row(channel++) = (column.rate == 1.0 ? velocity : column.rate * velocity).transpose();
      } else if (column.sincos) {
        values.row(channel++) = sine_of(raw, column.wrap).transpose();
        values.row(channel++) = cosine_of(raw, column.wrap).transpose();
      } else {
        values.row(channel++) = raw.transpose();
      }
    }
    return values;
  }

  /// Rows of the run, from its first, whose cell is empty; they increase.
  static std::vector<Index> empty_rows(const LogFile& log, const LogRun& run, const std::string& heading) {
    std::vector<Index> rows;
    if (const auto found = log.empty.find(heading); found != log.empty.end())
      for (const Index row : found->second)
        if (row >= run.first && row < run.first + run.rows) rows.push_back(row - run.first);
    return rows;
  }

  /// Calls visit(first, last) for each stretch of neighbouring rows.
  template <class Visit>
  static void for_each_stretch(const std::vector<Index>& rows, const Visit& visit) {
    for (std::size_t i = 0, from = 0; i < rows.size(); ++i) {
      if (i + 1 < rows.size() && rows[i + 1] == rows[i] + 1) continue;
      visit(rows[from], rows[i]);
      from = i + 1;
    }
  }

  /// Between the values before and after each stretch; at an end of the run the only one of them is held.
  static void draw_lines(const std::vector<Index>& rows, const VectorXd& time_s, VectorXd& values) {
    for_each_stretch(rows, [&](Index first, Index last) {
      const Index before = first - 1, after = last + 1;
      if (before < 0 && after >= values.size()) return;  // no value in this run: its weight is 0
      const double low = values[before < 0 ? after : before], high = values[after < values.size() ? after : before];
      for (Index k = first; k <= last; ++k) {
        const bool inside = before >= 0 && after < values.size();
        const double share = inside ? (time_s[k] - time_s[before]) / (time_s[after] - time_s[before]) : 0.0;
        values[k] = low + share * (high - low);
      }
    });
  }

  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> missing_outputs(const LogFile& log, const LogRun& run) const {
    Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> missing(static_cast<Index>(schema_.output_channels.size()),
                                                               run.rows);
    missing.setConstant(false);
    Index channel = 0;
    for (const LogColumn& output : schema_.outputs) {
      const Index channels = output.sincos ? 2 : 1;
      for (const Index row : empty_rows(log, run, output.heading)) missing.block(channel, row, channels, 1) = true;
      channel += channels;
    }
    if (!missing.any()) missing.resize(0, 0);
    return missing;
  }

  /// A short hole of a position hardly shows in its velocity; a long one is as an end of the log.
  void mask_empty_states(const LogFile& log, const LogRun& run, const VectorXd& time_s, VectorXd& weight) const {
    const double mask_s = config_.velocity_filter.mask_edges_s, long_s = 1.0 / config_.velocity_filter.cutoff_hz;
    for (const LogColumn& state : schema_.states)
      for_each_stretch(empty_rows(log, run, state.heading), [&](Index first, Index last) {
        const double from_s = time_s[std::max<Index>(first - 1, 0)], to_s = time_s[std::min(last + 1, run.rows - 1)];
        const bool spreads = state.derivative && to_s - from_s > long_s;
        if (spreads) weight = (time_s.array() > from_s - mask_s && time_s.array() < to_s + mask_s).select(0.0, weight);
        weight.segment(first, last - first + 1).setZero();
      });
  }

  VectorXd weights(const VectorXd& time_s) const {
    if (!filtered_) return VectorXd::Ones(time_s.size());
    const VectorXd weight = VectorXd::Ones(time_s.size());
    const double mask_s = config_.velocity_filter.mask_edges_s, end_s = time_s[time_s.size() - 1];
    return (time_s.array() < mask_s || time_s.array() > end_s - mask_s).select(0.0, weight);
  }

  const LogConfig& config_;
  const LogSchema& schema_;
  double sample_period_s_;
  bool filtered_;
  std::vector<SuspiciousSteps>& steps_;
};

std::string set_period(double period_s) {
  return fmt::format(
      "set [log] sample_period_s = {:.6g}, or 0 to take it from the stamps, if that is the rate in flight", period_s);
}

/// A log on another clock than the nominal one is used as it is stamped, and slowly.
void check_period(const LogFile& log, const LogRun& run, double nominal_s, std::vector<std::string>& notes) {
  const double median_s = median_step({run.time_s}), ratio = median_s / nominal_s;
  if (ratio > 100.0 || ratio < 0.01)
    throw Error(
        fmt::format("{}: the median step is {:.6g} s, the nominal sample period {:.6g} s: is the unit of the time "
                    "column s, ms, us or ns? set unit at the column with role = \"time\"",
                    log.path, median_s, nominal_s));
  if (run.grid.regular && !has_period(run.grid, nominal_s))
    note_once(notes,
              fmt::format("{}: its stamps are regular at {:.6g} s, and the nominal sample period is {:.6g} s: {}",
                          log.name, run.grid.period_s, nominal_s, set_period(run.grid.period_s)));
  else if (!run.grid.regular && (ratio > 1.05 || ratio < 0.95))
    note_once(notes, fmt::format("{}: the median step is {:.6g} s, the nominal sample period {:.6g} s: {}", log.name,
                                 median_s, nominal_s, set_period(median_s)));
}

using Runs = std::vector<std::vector<LogRun>>;  // of each file

/// Regular logs of one clock: their mean step, over all of them, which does not drift; else the median.
double nominal_period(const LogConfig& config, const Runs& runs) {
  if (config.sample_period_s > 0.0) return config.sample_period_s;
  double duration_s = 0.0, steps = 0.0;
  std::vector<VectorXd> times;
  for (const auto& file : runs)
    for (const LogRun& run : file) {
      const double count = run.grid.counts[run.rows - 1];
      duration_s += count * run.grid.period_s;
      steps += count;
      times.push_back(run.time_s);
    }
  const double mean_s = duration_s / steps;
  for (const auto& file : runs)
    for (const LogRun& run : file)
      if (!run.grid.regular || !has_period(run.grid, mean_s)) return median_step(times);
  return mean_s;
}

Runs split(const LogConfig& config, const std::vector<LogFile>& logs, std::vector<std::string>& notes) {
  std::vector<VectorXd> times;
  for (const LogFile& log : logs) times.push_back(log.time_s);
  const double about_s = config.sample_period_s > 0.0 ? config.sample_period_s : median_step(times);
  Runs runs;
  for (const LogFile& log : logs)
    runs.push_back(split_at_gaps(log, config.max_gap_s > 0.0 ? config.max_gap_s : kGapPeriods * about_s, notes));
  return runs;
}

/// A run that is too short is dropped and noted; a log without a gap, or with no run left, is an error.
void load_runs(const Loader& loader, const LogFile& log, const std::vector<LogRun>& runs, Dataset& data,
               LogReport& report) {
  std::string first_dropped, why;
  std::size_t dropped = 0;
  bool nominal = true;
  std::vector<VectorXd> times_s;
  for (const LogRun& run : runs) {
    try {
      data.trajectories.push_back(loader.load(log, run));
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
        fmt::format("{}: no run between its gaps can be used, the first since: {}: raise [log] max_gap_s, or use "
                    "a longer log",
                    log.path, why.empty() ? "it has one sample, or an output or input without a value" : why));
  data.uniform = data.uniform && nominal;
  report.files.push_back(report_time_stamps(log.name, times_s, data.sample_period_s));
  report.files.back().nominal = nominal;
  if (dropped > 0)
    note_once(report.notes,
              fmt::format(
                  "{}: unusable, and dropped: {} of its {} runs, the first {} ({}); raise [log] max_gap_s to keep the "
                  "log whole",
                  log.name, dropped, runs.size(), first_dropped, why));
}

/// Every `every`-th sample from `first` on.
Trajectory thinned(const Trajectory& run, Eigen::Index every, Eigen::Index first) {
  const Index samples = (run.samples() - first + every - 1) / every;
  const auto columns = [&](const Eigen::MatrixXd& signal) -> Eigen::MatrixXd {
    if (signal.size() == 0) return {};
    return signal(Eigen::all, Eigen::seqN(first, samples, every));
  };
  Trajectory thin;
  thin.source = first == 0 ? run.source : fmt::format("{} from its row {}", run.source, first + 1);
  thin.log = run.log;
  thin.time_s = run.time_s(Eigen::seqN(first, samples, every)).array() - run.time_s(first);
  thin.outputs = columns(run.outputs);
  thin.states = columns(run.states);
  thin.inputs = columns(run.inputs);
  thin.weight = run.weight(Eigen::seqN(first, samples, every));
  if (run.missing.size() != 0) thin.missing = run.missing(Eigen::all, Eigen::seqN(first, samples, every));
  return thin;
}

/// Thins all runs: each becomes `phases` runs, which begin at its first, second, ... row.
void thin(Index every, Index phases, Dataset& data) {
  if (every == 1) return;
  std::vector<Trajectory> thinned_runs;
  for (const Trajectory& run : data.trajectories)
    for (Index first = 0; first < phases; ++first) {
      if (run.samples() < first + every + 1)
        throw Error(
            fmt::format("{}: {} rows, and every = {} leaves no two samples of them: use a longer log, or a "
                        "smaller number",
                        run.source, run.samples(), every));
      thinned_runs.push_back(thinned(run, every, first));
    }
  data.trajectories = std::move(thinned_runs);
  data.sample_period_s *= static_cast<double>(every);
}

/// Loads files that exist, adding what is found to `report`. `decides`: these logs decide what is said of the columns.
/// `all_phases`: with every = n, n runs of each log in place of one, so that no row is lost.
Dataset load(LogConfig config, const LogSchema& schema, const std::vector<std::string>& paths, bool decides,
             bool all_phases, LogReport& report) {
  for (const ColumnConfig& column : config.columns)
    if (column.find_delay)
      throw Error(
          fmt::format("[[log.columns]] \"{}\": delay_s = \"estimate\" is for nlo train and nlo crossvalidate; "
                      "write the delay in seconds here",
                      column.name));
  config.sample_period_s /= config.every;  // from here on that of the rows
  std::vector<LogFile> logs;
  for (const std::string& path : paths) logs.push_back(read_log(path, schema, config.sample_period_s));
  Dataset data;
  data.outputs = schema.output_channels;
  data.states = schema.state_channels;
  data.inputs = schema.input_channels;
  data.reads_inputs = !schema.input_channels.empty();
  data.mirror = schema.mirror;
  for (Index channel = 0; const LogColumn& output : schema.outputs) {
    if (output.sincos) data.output_angles.push_back({channel, output.wrap});
    channel += output.sincos ? 2 : 1;
  }
  if (logs.empty()) {
    data.sample_period_s = config.sample_period_s * config.every;
    return data;
  }
  const Runs runs = split(config, logs, report.notes);
  data.sample_period_s = report.sample_period_s = nominal_period(config, runs);
  const std::string doubt = time_unit_doubt(schema, config, logs);
  if (!doubt.empty()) report.notes.push_back(doubt);
  for (std::size_t i = 0; i < logs.size(); ++i) {
    std::vector<SuspiciousSteps> steps;
    const Loader loader(config, schema, data.sample_period_s, steps);
    if (!runs[i].empty()) check_period(logs[i], runs[i].front(), data.sample_period_s, report.notes);
    try {
      load_runs(loader, logs[i], runs[i], data, report);
    } catch (const Error& error) {
      if (doubt.empty()) throw;
      throw Error(fmt::format("{}; {}", error.what(), doubt));
    }
    note_suspicious_steps(steps, logs[i].name, report.notes);
    report.contents.push_back(content_of(logs[i], listed_headings(schema)));
  }
  count_empty_cells(schema, logs, report.empty_cells);
  note_outliers(schema, logs, report.notes);
  if (decides) {
    note_suspicious_columns(schema, logs, report.notes);
    note_logged_velocities(schema, config.velocity_filter, logs, runs, data.sample_period_s, report.notes);
  }
  // One run as it is stamped decides for all: their steps share a table.
  if (!data.uniform)
    for (TimeStampReport& file : report.files) file.nominal = false;
  thin(config.every, all_phases ? config.every : 1, data);
  data.compute_outputs();
  return data;
}

}  // namespace

Dataset load_logs(const LogConfig& config, const std::string& directory, const std::vector<std::string>& files,
                  LogReport* report) {
  const std::vector<std::string> paths = expand_files(directory, files);
  if (paths.empty()) throw Error("no logs are named: expected at least one file or glob");
  LogReport found;
  Dataset data = load(config, resolve_columns(config), paths, true, false, found);
  note_empty_cells(found.empty_cells, found.notes);
  found.data_hash = content_hash(paths);
  if (report != nullptr) *report = std::move(found);
  return data;
}

LogSplits load_log_splits(const LogConfig& config, const std::string& directory, bool mirrored) {
  const LogSchema schema = resolve_columns(config);
  const SplitFiles files = expand_splits(config, directory);
  LogSplits splits;
  splits.train = load(config, schema, files.train, true, true, splits.report);
  const std::vector<LogContent> trained = splits.report.contents;
  splits.remembered = remember(trained, splits.train, mirrored);

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

std::string to_text(const LogReport& report) {
  std::size_t width = 4;
  for (const TimeStampReport& file : report.files) width = std::max(width, named(file).size());
  std::string text =
      fmt::format("nominal sample period {:.4g} ms; steps between time stamps in ms:\n", 1e3 * report.sample_period_s);
  text += fmt::format("{:<{}}  samples  seconds   median     1 %    99 %     max  gaps > 1.5 periods  steps used\n",
                      "file", width);
  for (const TimeStampReport& file : report.files)
    text += fmt::format("{:<{}}  {:7}  {:7.2f}  {:7.3f} {:7.3f} {:7.3f} {:7.3f}  {:18}  {}\n", named(file), width,
                        file.samples, file.duration_s, 1e3 * file.median_s, 1e3 * file.p01_s, 1e3 * file.p99_s,
                        1e3 * file.max_s, file.gaps, file.nominal ? "nominal" : "as stamped");
  for (const std::string& line : report.notes) text += "note: " + line + "\n";
  return text;
}

}  // namespace nlo::trainer

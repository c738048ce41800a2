// SPDX-License-Identifier: MIT
#include "trainer/data/log_dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "codegen/error.h"
#include "trainer/data/angle.h"
#include "trainer/data/csv.h"
#include "trainer/data/log_files.h"
#include "trainer/data/log_schema.h"
#include "trainer/data/zero_phase_filter.h"

namespace nlo::trainer {
namespace {

using codegen::Error;
using Eigen::Index;
using Eigen::VectorXd;

/// Notes are kept in order and once each: a note about a column holds for all logs.
void note(std::vector<std::string>& notes, const std::string& text) {
  if (std::find(notes.begin(), notes.end(), text) == notes.end()) notes.push_back(text);
}

VectorXd read_time(const CsvTable& table, const LogSchema& schema, double sample_period_s) {
  if (table.rows() < 2)
    throw Error(fmt::format("{}: one data row: expected a log of at least two samples", table.file()));
  if (schema.time_heading.empty())
    return VectorXd::LinSpaced(table.rows(), 0.0, sample_period_s * static_cast<double>(table.rows() - 1));
  const VectorXd stamps = table.column(schema.time_heading);
  for (Index k = 1; k < stamps.size(); ++k)
    if (!(stamps[k] > stamps[k - 1]))
      throw Error(fmt::format("{}:{}:{}: time does not increase: {} follows {}: sort the rows and drop repeated ones",
                              table.file(), table.line(k), schema.time_heading, stamps[k], stamps[k - 1]));
  return (stamps.array() - stamps[0]) * schema.time_unit_s;
}

double half_turn_in(const std::string& unit) {
  return unit == "rad" ? std::numbers::pi : unit == "deg" || unit == "°" ? 180.0 : 0.0;
}

void note_suspicious_steps(const LogColumn& column, const VectorXd& values, const std::string& file,
                           std::vector<std::string>& notes) {
  const auto steps = (values.tail(values.size() - 1) - values.head(values.size() - 1)).array().abs();
  if (const double half_turn = half_turn_in(column.unit); column.wrap == 0.0 && !column.derivative && half_turn > 0.0)
    if (const Index jumps = (steps > half_turn).count(); jumps > 0)
      note(notes, fmt::format("{}: \"{}\" jumps by more than half a turn {} times: an angle that wraps? give its wrap",
                              file, column.heading, jumps));
  if (column.wrap > 0.0)
    if (const Index wide = (steps > column.wrap / 3.0).count(); wide > 0)
      note(notes, fmt::format("{}: \"{}\" turns by more than a third of a turn between samples {} times: unwrapping is "
                              "uncertain there",
                              file, column.heading, wide));
}

/// A log's column, unwrapped when it is an angle.
VectorXd read_column(const CsvTable& table, const LogColumn& column, std::vector<std::string>& notes) {
  VectorXd values = table.column(column.heading);
  if (column.wrap > 0.0) values = unwrap(values, column.wrap);
  note_suspicious_steps(column, values, std::filesystem::path(table.file()).filename().string(), notes);
  return values;
}

/// What a log holds before its channels are made: read first, since the nominal period may come from all of them.
struct Log {
  CsvTable table;
  VectorXd time_s;
};

class Loader {
 public:
  Loader(const LogConfig& config, const LogSchema& schema, double sample_period_s, LogReport& report)
      : config_(config), schema_(schema), sample_period_s_(sample_period_s), report_(report) {}

  Trajectory load(const Log& log) const {
    Trajectory run;
    run.source = std::filesystem::path(log.table.file()).filename().string();
    run.time_s = log.time_s;
    report_.files.push_back(report_time_stamps(run.source, run.time_s, sample_period_s_));
    check_rate(report_.files.back(), log.table.file());
    run.outputs = channels(log, schema_.outputs, schema_.output_channels.size());
    run.states = channels(log, schema_.states, schema_.state_channels.size());
    run.weight = weights(log);
    for (const LogColumn& input : schema_.inputs) {
      log.table.column(input.heading);
      note(report_.notes, fmt::format("input \"{}\" is read and not used: this observer is not driven", input.name));
    }
    return run;
  }

 private:
  Eigen::MatrixXd channels(const Log& log, const std::vector<LogColumn>& columns, std::size_t count) const {
    Eigen::MatrixXd values(static_cast<Index>(count), log.time_s.size());
    Index channel = 0;
    for (const LogColumn& column : columns) {
      const VectorXd raw = read_column(log.table, column, report_.notes);
      if (column.derivative) {
        values.row(channel++) = velocity(log, raw).transpose();
      } else if (column.sincos) {
        values.row(channel++) = sine_of(raw, column.wrap).transpose();
        values.row(channel++) = cosine_of(raw, column.wrap).transpose();
      } else {
        values.row(channel++) = raw.transpose();
      }
    }
    return values;
  }

  VectorXd velocity(const Log& log, const VectorXd& position) const {
    try {
      return zero_phase_velocity(config_.velocity_filter, log.time_s, position, sample_period_s_);
    } catch (const Error& error) {
      throw Error(fmt::format("{}: {}", log.table.file(), error.what()));
    }
  }

  VectorXd weights(const Log& log) const {
    const bool filtered =
        std::any_of(schema_.states.begin(), schema_.states.end(), [](const auto& s) { return s.derivative; });
    VectorXd weight = VectorXd::Ones(log.time_s.size());
    if (!filtered) return weight;
    const double mask_s = config_.velocity_filter.mask_edges_s, end_s = log.time_s[log.time_s.size() - 1];
    weight = (log.time_s.array() < mask_s || log.time_s.array() > end_s - mask_s).select(0.0, weight);
    if (weight.sum() == 0.0)
      throw Error(fmt::format("{}: {:.3g} s long, all of it within mask_edges_s = {} s of its ends: use a longer log",
                              log.table.file(), end_s, mask_s));
    return weight;
  }

  void check_rate(const TimeStampReport& found, const std::string& path) const {
    const double ratio = found.median_s / sample_period_s_;
    if (ratio > 100.0 || ratio < 0.01)
      throw Error(
          fmt::format("{}: the median step is {:.6g} s, the nominal sample period {:.6g} s: is the unit of the time "
                      "column s, ms, us or ns?",
                      path, found.median_s, sample_period_s_));
    if (ratio > 2.0 || ratio < 0.5)
      note(report_.notes, fmt::format("{}: the median step is {:.6g} s, the nominal sample period {:.6g} s", found.file,
                                      found.median_s, sample_period_s_));
  }

  const LogConfig& config_;
  const LogSchema& schema_;
  double sample_period_s_;
  LogReport& report_;
};

double nominal_period(const LogConfig& config, const std::vector<Log>& logs) {
  if (config.sample_period_s > 0.0) return config.sample_period_s;
  std::vector<VectorXd> times;
  for (const Log& log : logs) times.push_back(log.time_s);
  return median_step(times);
}

/// Loads files that exist, adding what is found to `report`.
Dataset load(const LogConfig& config, const LogSchema& schema, const std::vector<std::string>& paths,
             LogReport& report) {
  std::vector<Log> logs;
  for (const std::string& path : paths) {
    CsvTable table = CsvTable::read(path);
    VectorXd time_s = read_time(table, schema, config.sample_period_s);
    logs.push_back({std::move(table), std::move(time_s)});
  }
  Dataset data;
  data.outputs = schema.output_channels;
  data.states = schema.state_channels;
  for (Index channel = 0; const LogColumn& output : schema.outputs) {
    if (output.sincos) data.output_angles.push_back({channel, output.wrap});
    channel += output.sincos ? 2 : 1;
  }
  data.uniform = schema.time_heading.empty();
  if (logs.empty()) {
    data.sample_period_s = config.sample_period_s;
    return data;
  }
  data.sample_period_s = report.sample_period_s = nominal_period(config, logs);
  const Loader loader(config, schema, data.sample_period_s, report);
  for (const Log& log : logs) data.trajectories.push_back(loader.load(log));
  return data;
}

}  // namespace

Dataset load_logs(const LogConfig& config, const std::string& directory, const std::vector<std::string>& files,
                  LogReport* report) {
  const std::vector<std::string> paths = expand_files(directory, files);
  if (paths.empty()) throw Error("no logs are named: expected at least one file or glob");
  LogReport found;
  Dataset data = load(config, resolve_columns(config), paths, found);
  found.data_hash = content_hash(paths);
  if (report != nullptr) *report = std::move(found);
  return data;
}

LogSplits load_log_splits(const LogConfig& config, const std::string& directory) {
  const LogSchema schema = resolve_columns(config);
  const SplitFiles files = expand_splits(config, directory);
  LogSplits splits;
  splits.train = load(config, schema, files.train, splits.report);
  LogConfig on_training_clock = config;
  on_training_clock.sample_period_s = splits.train.sample_period_s;
  splits.validation = load(on_training_clock, schema, files.validation, splits.report);
  splits.test = load(on_training_clock, schema, files.test, splits.report);

  std::vector<std::string> all = files.train;
  all.insert(all.end(), files.validation.begin(), files.validation.end());
  all.insert(all.end(), files.test.begin(), files.test.end());
  splits.report.data_hash = content_hash(all);
  return splits;
}

std::string to_text(const LogReport& report) {
  std::size_t width = 4;
  for (const TimeStampReport& file : report.files) width = std::max(width, file.file.size());
  std::string text =
      fmt::format("nominal sample period {:.4g} ms; steps between time stamps in ms:\n", 1e3 * report.sample_period_s);
  text += fmt::format("{:<{}}  samples  seconds   median     1 %    99 %     max  gaps > 1.5 periods\n", "file", width);
  for (const TimeStampReport& file : report.files)
    text += fmt::format("{:<{}}  {:7}  {:7.2f}  {:7.3f} {:7.3f} {:7.3f} {:7.3f}  {:4}\n", file.file, width,
                        file.samples, file.duration_s, 1e3 * file.median_s, 1e3 * file.p01_s, 1e3 * file.p99_s,
                        1e3 * file.max_s, file.gaps);
  for (const std::string& line : report.notes) text += "note: " + line + "\n";
  return text;
}

}  // namespace nlo::trainer

// SPDX-License-Identifier: MIT
#include "trainer/data/log_delays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/base/number_text.h"
#include "trainer/data/angle.h"
#include "trainer/data/log_file.h"
#include "trainer/data/log_files.h"
#include "trainer/data/log_schema.h"
#include "trainer/data/log_stamps.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kLongest = 32.0;    // longest delay of the search [rows]; usual delays are a few rows
constexpr double kSureEnough = 0.5;  // largest standard deviation of a found delay, in rows

/// Interpolates `values` linearly at the increasing times wanted_s. Beyond the ends the end values hold.
VectorXd interpolated(const VectorXd& time_s, const VectorXd& values, const VectorXd& wanted_s) {
  VectorXd result(wanted_s.size());
  Index k = 0;
  for (Index i = 0; i < wanted_s.size(); ++i) {
    const double t = wanted_s[i];
    while (k + 2 < time_s.size() && time_s[k + 1] <= t) ++k;
    const double share = std::clamp((t - time_s[k]) / (time_s[k + 1] - time_s[k]), 0.0, 1.0);
    result[i] = (1.0 - share) * values[k] + share * values[k + 1];
  }
  return result;
}

/// Returns the measured columns of a log, each once: outputs and states of the file, with angles to unwrap.
std::vector<LogColumn> measured_columns(const LogSchema& schema) {
  std::vector<LogColumn> columns;
  for (const auto* all : {&schema.outputs, &schema.states})
    for (const LogColumn& column : *all)
      if (std::none_of(columns.begin(), columns.end(), [&](const auto& c) { return c.heading == column.heading; }))
        columns.push_back(column);
  return columns;
}

/// Returns the run on an even grid, because stamps of real logs jitter and the search counts in samples.
DelayRun on_grid(const LogFile& log, const LogRun& run, double period_s, const std::vector<LogColumn>& measured,
                 const std::vector<LogColumn>& inputs) {
  const auto samples = static_cast<Index>(std::floor(run.time_s[run.rows - 1] / period_s)) + 1;
  const VectorXd grid_s = VectorXd::LinSpaced(samples, 0.0, static_cast<double>(samples - 1) * period_s);
  const auto read = [&](const LogColumn& column) -> Eigen::RowVectorXd {
    VectorXd values = log.values(column).segment(run.first, run.rows);
    if (column.wrap > 0.0) values = unwrap(values, column.wrap);
    return interpolated(run.time_s, values, grid_s).transpose();
  };
  DelayRun result{Eigen::MatrixXd(static_cast<Index>(measured.size()), samples),
                  Eigen::MatrixXd(static_cast<Index>(inputs.size()), samples)};
  for (std::size_t i = 0; i < measured.size(); ++i) result.measured.row(static_cast<Index>(i)) = read(measured[i]);
  for (std::size_t i = 0; i < inputs.size(); ++i) result.inputs.row(static_cast<Index>(i)) = read(inputs[i]);
  return result;
}

}  // namespace

VectorXd delayed(const VectorXd& time_s, const VectorXd& values, double delay_s) {
  return interpolated(time_s, values, time_s.array() - delay_s);
}

std::vector<LogDelay> find_log_delays(LogConfig& config, const std::string& directory, Hold input_hold) {
  const auto asks = [](const ColumnConfig& column) { return column.find_delay; };
  if (std::none_of(config.columns.begin(), config.columns.end(), asks)) return {};
  const LogSchema schema = resolve_columns(config);
  const std::vector<LogColumn> measured = measured_columns(schema);
  const double given_s = config.sample_period_s / config.every;
  std::vector<LogFile> logs;
  std::vector<VectorXd> times;
  for (const std::string& path : expand_files(directory, config.train_files)) {
    logs.push_back(read_log(path, schema, given_s));
    times.push_back(logs.back().time_s);
  }
  const double period_s = given_s > 0.0 ? given_s : median_step(times);
  std::vector<DelayRun> runs;
  std::vector<std::string> notes;
  for (const LogFile& log : logs)
    for (const LogRun& run :
         split_at_gaps(log, config.max_gap_s > 0.0 ? config.max_gap_s : kGapPeriods * period_s, notes))
      runs.push_back(on_grid(log, run, period_s, measured, schema.inputs));

  // If every n-th row is used, a command counts as if it had acted over n rows. This is earlier by half the time of the
  // other n - 1 rows.
  const double earlier = input_hold == Hold::kZeroOrder ? 0.5 * (config.every - 1) : 0.0;
  std::vector<double> angles, known;
  for (const LogColumn& column : measured) angles.push_back(column.wrap);
  std::vector<ColumnConfig*> columns;
  for (ColumnConfig& column : config.columns) {
    if (column.role != ColumnRole::kInput) continue;
    columns.push_back(&column);
    known.push_back(column.find_delay ? std::numeric_limits<double>::quiet_NaN() : column.delay_s / period_s - earlier);
  }
  std::vector<FoundDelay> found;
  try {
    found = find_delays(runs, angles, known, input_hold, kLongest);
  } catch (const codegen::Error& error) {
    throw codegen::Error(
        fmt::format("[[log.columns]] delay_s = \"estimate\": {}; write delay_s in seconds", error.what()));
  }
  std::vector<LogDelay> result;
  for (std::size_t j = 0; j < columns.size(); ++j) {
    if (!asks(*columns[j])) continue;
    if (found[j].at_the_end || found[j].deviation > kSureEnough)
      throw codegen::Error(fmt::format(
          "[[log.columns]] \"{}\": delay_s = \"estimate\": the logs do not determine it ({:.3g} +- {:.2g} rows of "
          "{:.4g} s fit best); write it in seconds, or leave it out",
          columns[j]->name, found[j].samples, found[j].deviation, period_s));
    columns[j]->find_delay = false;
    // Four digits, which the text of the experiment keeps and which hide the rounding of other machines.
    columns[j]->delay_s = std::stod(fmt::format("{:.4g}", std::max(found[j].samples + earlier, 0.0) * period_s));
    result.push_back({columns[j]->name, columns[j]->delay_s, period_s * config.every, found[j]});
  }
  return result;
}

std::string to_text(const LogDelay& delay) {
  const std::string error =
      fmt::format("+- {:.2g} rows; with this delay {:.3g} % of the variance stay unexplained, without a delay {:.3g} %",
                  delay.found.deviation, 100.0 * delay.found.with, 100.0 * delay.found.without);
  if (delay.delay_s == 0.0)
    return fmt::format("{} acts without a delay after its column ({:.3g} rows {})", delay.input, delay.found.samples,
                       error);
  return fmt::format("{} acts {:.4g} s ({:.3g} samples of the observer) later than its column shows ({})", delay.input,
                     delay.delay_s, delay.samples(), error);
}

std::string delays_in_flight(const LogConfig& config, double sample_period_s) {
  std::string text;
  for (const ColumnConfig& column : config.columns)
    if (column.delay_s > 0.0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", column.name,
                          shortest_text(std::round(column.delay_s / sample_period_s * 1e4) / 1e4));
  return text;
}

}  // namespace nlo::trainer

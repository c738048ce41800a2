// SPDX-License-Identifier: MIT
#include "trainer/data/log_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <utility>

#include "trainer/data/log_report.h"
#include "trainer/data/time_stamps.h"
#include "trainer/data/units.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Notes = std::vector<std::string>;

constexpr double kTurnRad = 2.0 * std::numbers::pi, kTurnDeg = 360.0;

/// Two columns are copies if a linear function of one explains the other up to this share of its deviation. Copies that
/// are printed with three or more digits stay below it; a second sensor of the same quantity does not.
constexpr double kCopy = 1e-3;

/// Range of a column over all logs.
struct Spread {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  Index steps = 0;
  Index jumps_rad = 0, jumps_deg = 0;  ///< number of steps near 2 pi and near 360
  Index crossings = 0;                 ///< number of steps of more than half a wrap
  double largest() const { return std::max(std::abs(low), std::abs(high)); }
};

Spread spread_of(const LogColumn& column, const std::vector<LogFile>& logs) {
  Spread spread;
  const auto nearly = [](const auto& steps, double turn) {
    return (steps > 0.9 * turn && steps < 1.02 * turn).count();
  };
  for (const LogFile& log : logs) {
    const VectorXd x = log.values(column);
    const Eigen::ArrayXd steps = (x.tail(x.size() - 1) - x.head(x.size() - 1)).array().abs();
    spread.low = std::min(spread.low, x.minCoeff());
    spread.high = std::max(spread.high, x.maxCoeff());
    spread.steps += steps.size();
    spread.jumps_rad += nearly(steps, kTurnRad);
    spread.jumps_deg += nearly(steps, kTurnDeg);
    if (column.wrap > 0.0) spread.crossings += (steps > 0.5 * column.wrap).count();
  }
  return spread;
}

void note_constant(const LogColumn& column, const Spread& spread, Notes& notes) {
  if (spread.low < spread.high) return;
  notes.push_back(
      fmt::format("\"{}\" is {:.6g} in every row: is the sensor off, or is it the wrong column? choose the right "
                  "column, or leave it out",
                  column.heading, spread.low));
}

/// Checks the unit of an angle. Returns true if it added a note, because then the wrap may be wrong too.
bool note_unit(const LogColumn& column, const Spread& spread, Notes& notes) {
  const char* mend = column.wrap > 0.0 ? "unit and wrap" : "unit";
  // Read in rad, the range is more than two turns in each direction; read in degrees, it is within one turn.
  const bool too_wide = spread.largest() > 2.0 * kTurnRad &&
                        (spread.largest() <= 0.5 * kTurnDeg || (spread.low >= 0.0 && spread.high <= kTurnDeg));
  if (column.unit == "rad" && (spread.jumps_deg > 0 || too_wide)) {
    notes.push_back(fmt::format(
        "\"{}\" runs from {:.4g} to {:.4g} {}: is it in degrees although its unit is rad? if so, set {} to deg",
        column.heading, spread.low, spread.high, spread.jumps_deg > 0 ? "and jumps by 360" : "rad", mend));
    return true;
  }
  const bool too_narrow = spread.largest() < 1.02 * kTurnRad && (column.wrap > 0.0 || spread.jumps_rad > 0);
  if (is_degrees(column.unit) && too_narrow) {
    notes.push_back(fmt::format(
        "\"{}\" runs from {:.4g} to {:.4g} {}: is it in rad although its unit is degrees? if so, set {} to rad",
        column.heading, spread.low, spread.high,
        spread.jumps_rad > 0 ? "and jumps by 2 pi" : "deg, a fiftieth of a turn", mend));
    return true;
  }
  return false;
}

void note_wrap(const LogColumn& column, const Spread& spread, Notes& notes) {
  if (column.wrap == 0.0) return;
  if (spread.crossings == 0 && spread.high - spread.low < 0.5 * column.wrap)
    notes.push_back(
        fmt::format("\"{}\" never wraps: it stays between {:.4g} and {:.4g}, within half a turn. If the rig cannot "
                    "turn further, remove wrap: then more [observer] features are possible",
                    column.heading, spread.low, spread.high));
  // An angle that moves half a turn per step crosses the wrap in every second step; with a third of a turn per step, in
  // every third step. From there on, unwrapping is uncertain.
  if (3 * spread.crossings > spread.steps)
    notes.push_back(
        fmt::format("\"{}\" crosses its wrap in {:.0f} % of the steps: either its full turn is not {:.4g}, or it turns "
                    "too fast for the sample period; check unit and wrap",
                    column.heading, 100.0 * static_cast<double>(spread.crossings) / static_cast<double>(spread.steps),
                    column.wrap));
}

/// The line b = slope a + offset over all logs, and the remaining share of b's deviation.
struct Line {
  double slope = 0.0, offset = 0.0, rest = 1.0;
};

Line line_through(const std::string& a, const std::string& b, const std::vector<LogFile>& logs) {
  double count = 0.0, mean_a = 0.0, mean_b = 0.0, aa = 0.0, ab = 0.0, bb = 0.0;
  for (const LogFile& log : logs) {
    mean_a += log.column(a).sum();
    mean_b += log.column(b).sum();
    count += static_cast<double>(log.time_s.size());
  }
  mean_a /= count;
  mean_b /= count;
  for (const LogFile& log : logs) {
    const Eigen::ArrayXd x = log.column(a).array() - mean_a, y = log.column(b).array() - mean_b;
    aa += x.square().sum();
    ab += (x * y).sum();
    bb += y.square().sum();
  }
  if (!(aa > 0.0 && bb > 0.0)) return {};  // another note reports constant columns
  const double slope = ab / aa;
  return {slope, mean_b - slope * mean_a, std::sqrt(std::max(0.0, 1.0 - slope * ab / bb))};
}

void note_copies(const std::vector<std::string>& headings, const std::vector<LogFile>& logs, Notes& notes) {
  for (std::size_t i = 0; i < headings.size(); ++i)
    for (std::size_t j = i + 1; j < headings.size(); ++j) {
      const Line line = line_through(headings[i], headings[j], logs);
      if (line.rest > kCopy) continue;
      const bool same = std::abs(line.slope - 1.0) < kCopy && std::abs(line.offset) < kCopy;
      notes.push_back(fmt::format(
          "\"{}\" and \"{}\" contain the same signal{}, so an observer learns nothing from the second: remove one, or "
          "name the right column",
          headings[i], headings[j],
          same ? "" : fmt::format(" (the second is {:.4g} times the first, {:+.4g})", line.slope, line.offset)));
    }
}

}  // namespace

std::string time_unit_doubt(const LogSchema& schema, const LogConfig& config, const std::vector<LogFile>& logs) {
  constexpr double kBeyond = 1e11;  // [s]: a stamp in the year 5138, or a log of that length
  constexpr Index kManyRows = 200;
  if (schema.time_heading.empty() || logs.empty()) return "";
  static constexpr std::array<std::pair<const char*, double>, 3> kFiner = {{{"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}}};
  const auto finer = [&](double value_s, double below_s) {
    for (const auto& [name, unit_s] : kFiner)
      if (unit_s < schema.time_unit_s && value_s / schema.time_unit_s * unit_s < below_s) return name;
    return "ns";
  };
  const std::string column = "the column with role = \"time\"";
  for (const LogFile& log : logs)
    if (const double latest_s = std::max(std::abs(log.start_s), log.time_s[log.time_s.size() - 1]); latest_s > kBeyond)
      return fmt::format("{}: \"{}\" reaches {:.3g} s, which is beyond the year 5000: set unit = \"{}\" at {}",
                         log.name, schema.time_heading, latest_s, finer(latest_s, kBeyond), column);
  if (config.sample_period_s > 0.0 || std::ranges::any_of(logs, &LogFile::has_time_unit)) return "";
  Index rows = 0;
  std::vector<VectorXd> times;
  for (const LogFile& log : logs) rows += log.time_s.size(), times.push_back(log.time_s);
  const double step_s = median_step(times);
  if (step_s < 1.0 || rows < kManyRows) return "";
  const char* unit = finer(step_s, 1.0);
  return fmt::format(
      "\"{}\" has no unit and is read in s, which gives a row every {:.4g} s: if its stamps are in {}, set unit = "
      "\"{}\" at {}; if they are in s, set unit = \"s\"",
      schema.time_heading, step_s, unit, unit, column);
}

void count_suspicious_steps(const LogColumn& column, const VectorXd& values, std::vector<SuspiciousSteps>& found) {
  auto entry = std::find_if(found.begin(), found.end(), [&](const auto& steps) { return steps.column == &column; });
  if (entry == found.end()) entry = found.insert(found.end(), {&column});
  const auto steps = (values.tail(values.size() - 1) - values.head(values.size() - 1)).array().abs();
  if (column.wrap > 0.0) entry->wide += (steps > column.wrap / 3.0).count();
}

void note_suspicious_steps(const std::vector<SuspiciousSteps>& found, const std::string& file, Notes& notes) {
  for (const SuspiciousSteps& steps : found) {
    if (steps.wide > 0)
      note_once(notes, fmt::format("{}: \"{}\" turns by more than a third of a turn between two samples ({} times): "
                                   "unwrapping is uncertain there",
                                   file, steps.column->heading, steps.wide));
  }
}

void note_suspicious_columns(const LogSchema& schema, const std::vector<LogFile>& logs, Notes& notes) {
  if (logs.empty()) return;
  std::set<std::string> seen;
  for (const auto* columns : {&schema.outputs, &schema.states, &schema.inputs})
    for (const LogColumn& column : *columns) {
      if (!seen.insert(column.heading).second) continue;
      const Spread spread = spread_of(column, logs);
      note_constant(column, spread, notes);
      if (column.derivative || !(spread.low < spread.high)) continue;
      if (!note_unit(column, spread, notes)) note_wrap(column, spread, notes);
    }
  note_copies(listed_headings(schema), logs, notes);
}

}  // namespace nlo::trainer

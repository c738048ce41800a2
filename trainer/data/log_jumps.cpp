// SPDX-License-Identifier: MIT
#include "trainer/data/log_jumps.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <string_view>

#include "trainer/base/quantile.h"
#include "trainer/config/value.h"
#include "trainer/data/units.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Notes = std::vector<std::string>;

/// A column over all runs, one after another.
struct Signal {
  const LogColumn* column = nullptr;
  VectorXd x;
  double range = 0.0;

  double step(Index k) const { return x[k] - x[k - 1]; }
};

/// File and row of each sample of all runs.
struct Samples {
  std::vector<const LogFile*> files;
  std::vector<Index> rows;     ///< row in its file
  std::vector<bool> is_first;  ///< true for the first sample of a run, whose predecessor is in another run

  std::string place(Index k) const {
    const auto at = static_cast<std::size_t>(k);
    return fmt::format("{}:{}", files[at]->name, files[at]->lines[static_cast<std::size_t>(rows[at])]);
  }
  bool follows(Index k) const { return k > 0 && !is_first[static_cast<std::size_t>(k)]; }
  Index size() const { return static_cast<Index>(rows.size()); }
};

Samples samples_of(const std::vector<LogFile>& logs, const std::vector<std::vector<LogRun>>& runs) {
  Samples samples;
  for (std::size_t i = 0; i < logs.size(); ++i)
    for (const LogRun& run : runs[i])
      for (Index k = 0; k < run.rows; ++k) {
        samples.files.push_back(&logs[i]);
        samples.rows.push_back(run.first + k);
        samples.is_first.push_back(k == 0);
      }
  return samples;
}

std::vector<Signal> signals_of(const std::vector<LogColumn>& columns, const std::vector<LogFile>& logs,
                               const std::vector<std::vector<LogRun>>& runs, Index samples) {
  std::vector<Signal> signals;
  std::set<std::string> seen;
  for (const LogColumn& column : columns) {
    if (column.derivative || column.wrap > 0.0 || !seen.insert(column.heading).second) continue;
    Signal signal{&column, VectorXd(samples)};
    Index at = 0;
    for (std::size_t i = 0; i < logs.size(); ++i) {
      const VectorXd values = logs[i].values(column);
      for (const LogRun& run : runs[i]) {
        signal.x.segment(at, run.rows) = values.segment(run.first, run.rows);
        at += run.rows;
      }
    }
    signal.range = signal.x.maxCoeff() - signal.x.minCoeff();
    if (signal.range > 0.0) signals.push_back(std::move(signal));
  }
  return signals;
}

std::vector<double> as_list(const VectorXd& values) {
  return {values.begin(), values.end()};
}

/// Returns true if jumps have many sizes. The jumps of a square wave have one size despite noise.
bool has_many_sizes(const VectorXd& sizes) {
  constexpr double kSpread = 0.2;
  const std::vector<double> values = as_list(sizes);
  return value_at_rank(values, 0.95) - value_at_rank(values, 0.05) > kSpread * value_at_rank(values, 0.5);
}

/// Returns true if nearly all jumps of a column are of the kind that is looked for.
bool are_most(std::size_t found, std::size_t jumps) {
  constexpr double kMost = 0.8;
  return static_cast<double>(found) >= kMost * static_cast<double>(jumps);
}

std::string quoted(const std::vector<const Signal*>& signals) {
  std::string text;
  for (std::size_t i = 0; i < signals.size(); ++i)
    text += fmt::format("{}\"{}\"",
                        i == 0                    ? ""
                        : i + 1 == signals.size() ? " and "
                                                  : ", ",
                        signals[i]->column->heading);
  return text;
}

/// Returns "" for one jump, otherwise their number.
std::string how_many(std::size_t rows) {
  return rows == 1 ? "" : fmt::format(" ({} such rows)", rows);
}

// ---- Angles

double half_turn_in(const std::string& unit) {
  return unit == "rad" ? std::numbers::pi : is_degrees(unit) ? 180.0 : 0.0;
}

/// Returns the usual full turn that equals the size of the jumps; integers may have any full turn. The velocity of a
/// bouncing ball also jumps from end to end of its range, but not by a usual full turn.
std::optional<double> full_turn_near(double turn, bool is_whole) {
  constexpr double kNear = 0.02;
  constexpr auto kUsual =
      std::to_array<double>({2.0 * std::numbers::pi, std::numbers::pi, 360, 180, 400, 100, 24, 1, 3600, 36000});
  const double counts = std::exp2(std::round(std::log2(turn)));
  if (is_whole && counts >= 16.0 && std::abs(counts - turn) < kNear * turn) return counts;
  for (const double usual : kUsual)
    if (std::abs(usual - turn) < kNear * turn) return usual;
  return is_whole ? std::optional(std::round(turn)) : std::nullopt;
}

struct Wraps {
  std::size_t rows = 0;
  Index first = 0;
  double turn = 0.0;
};

std::optional<Wraps> wraps_by_unit(const Samples& samples, const Signal& signal, double half_turn) {
  Wraps wraps{.turn = 2.0 * half_turn};
  for (Index k = 1; k < samples.size(); ++k)
    if (samples.follows(k) && std::abs(signal.step(k)) > half_turn && wraps.rows++ == 0) wraps.first = k;
  return wraps.rows > 0 ? std::optional(wraps) : std::nullopt;
}

std::optional<Wraps> wraps_by_motion(const Samples& samples, const Signal& signal) {
  constexpr double kJump = 0.4, kEndToEnd = 0.75, kMiddle = 0.2;
  Wraps wraps;
  std::size_t jumps = 0;
  std::vector<double> turns;
  for (Index k = 2; k + 1 < samples.size(); ++k) {
    const double step = signal.step(k);
    if (!samples.follows(k) || std::abs(step) <= kJump * signal.range) continue;
    ++jumps;
    if (!samples.follows(k - 1) || !samples.follows(k + 1)) continue;
    const double motion = 0.5 * (signal.step(k - 1) + signal.step(k + 1));
    if (std::abs(step) < kEndToEnd * signal.range || !(step * motion < 0.0) || std::abs(motion) > 0.5 * std::abs(step))
      continue;
    if (turns.empty()) wraps.first = k;
    turns.push_back(std::abs(step) + std::abs(motion));
  }
  wraps.rows = turns.size();
  if (wraps.rows < 2 || !are_most(wraps.rows, jumps)) return std::nullopt;
  const double low = signal.x.minCoeff() + 0.25 * signal.range;
  const auto middle = (signal.x.array() > low && signal.x.array() < low + 0.5 * signal.range).count();
  if (static_cast<double>(middle) < kMiddle * static_cast<double>(signal.x.size())) return std::nullopt;
  const bool is_whole = (signal.x.array() == signal.x.array().round()).all();
  const std::optional<double> turn = full_turn_near(value_at_rank(turns, 0.5), is_whole);
  if (!turn) return std::nullopt;
  wraps.turn = *turn;
  return wraps;
}

void note_wraps(const Samples& samples, const Signal& signal, Notes& notes) {
  const double half_turn = half_turn_in(signal.column->unit);
  const auto wraps = half_turn > 0.0 ? wraps_by_unit(samples, signal, half_turn) : wraps_by_motion(samples, signal);
  if (!wraps) return;
  notes.push_back(fmt::format(
      "{}: \"{}\" jumps from {:.4g} to {:.4g}{}: is it {} that wraps? write wrap = {} and encoding = \"sincos\" at the "
      "column",
      samples.place(wraps->first), signal.column->heading, signal.x[wraps->first - 1], signal.x[wraps->first],
      how_many(wraps->rows), half_turn > 0.0 ? "an angle" : "an angle or a counter", show_wrap(wraps->turn)));
}

// Jumps of several columns in one row.

struct Jumps {
  Index row = 0;
  std::vector<std::size_t> signals;

  bool are_of(const std::vector<bool>& chosen) const {
    return std::ranges::any_of(signals, [&](std::size_t i) { return chosen[i]; });
  }
};

std::vector<Jumps> jumps_of(const Samples& samples, const std::vector<Signal>& signals) {
  constexpr double kJump = 0.1;  // share of the range
  std::vector<Jumps> jumps;
  for (Index k = 1; k < samples.size(); ++k) {
    if (!samples.follows(k)) continue;
    Jumps here{k, {}};
    for (std::size_t i = 0; i < signals.size(); ++i)
      if (std::abs(signals[i].step(k)) > kJump * signals[i].range) here.signals.push_back(i);
    if (!here.signals.empty()) jumps.push_back(std::move(here));
  }
  return jumps;
}

std::vector<std::size_t> count_jumps(const std::vector<Jumps>& jumps, std::size_t signals) {
  std::vector<std::size_t> count(signals, 0);
  for (const Jumps& here : jumps)
    for (const std::size_t i : here.signals) ++count[i];
  return count;
}

/// Returns true for "q_w", "/pose/orientation/x", "quat[2]".
bool is_called_quaternion(const std::string& heading) {
  std::string name;
  for (const char c : heading)
    if (const auto byte = static_cast<unsigned char>(c); byte < 0x80 && std::isalnum(byte) != 0)
      name += static_cast<char>(std::tolower(byte));
  if (name.find("quat") != std::string::npos || name.find("orientation") != std::string::npos) return true;
  constexpr auto kEnds = std::to_array<std::string_view>({"qw", "qx", "qy", "qz", "q0", "q1", "q2", "q3"});
  return std::ranges::any_of(kEnds, [&](std::string_view end) { return name.ends_with(end); });
}

/// Returns true if 2 to 4 neighbours, one of them `member`, have a constant norm.
bool has_constant_norm(const std::vector<Signal>& signals, std::size_t member) {
  constexpr double kConstant = 0.05;
  for (std::size_t count = 2; count <= 4; ++count)
    for (std::size_t from = member + 1 > count ? member + 1 - count : 0;
         from <= member && from + count <= signals.size(); ++from) {
      VectorXd squares = VectorXd::Zero(signals[member].x.size());
      for (std::size_t i = from; i < from + count; ++i) squares += signals[i].x.cwiseAbs2();
      const VectorXd norm = squares.cwiseSqrt();
      const std::vector<double> values = as_list(norm);
      if (value_at_rank(values, 0.95) - value_at_rank(values, 0.05) < kConstant * value_at_rank(values, 0.5))
        return true;
    }
  return false;
}

void note_quaternions(const Samples& samples, const std::vector<Signal>& signals, const std::vector<Jumps>& jumps,
                      bool are_measured, std::vector<bool>& is_explained, Notes& notes) {
  constexpr double kOpposite = 0.1;
  const std::vector<std::size_t> all = count_jumps(jumps, signals.size());
  std::vector<std::size_t> flips(signals.size(), 0), together(signals.size(), 0);
  const auto is_flip = [&](const Jumps& here) {
    return std::ranges::all_of(here.signals, [&](std::size_t i) {
      const Signal& s = signals[i];
      return std::abs(s.x[here.row] + s.x[here.row - 1]) <= kOpposite * std::abs(s.step(here.row));
    });
  };
  for (const Jumps& here : jumps) {
    if (!is_flip(here)) continue;
    for (const std::size_t i : here.signals) {
      ++flips[i];
      if (here.signals.size() > 1) ++together[i];
    }
  }
  std::vector<const Signal*> found;
  std::vector<bool> is_found(signals.size(), false);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    if (is_explained[i] || flips[i] == 0 || !are_most(flips[i], all[i])) continue;
    if (!has_many_sizes(signals[i].x.cwiseAbs())) continue;
    const bool is_together = together[i] >= 2 && are_most(together[i], flips[i]);
    if (!is_together && !is_called_quaternion(signals[i].column->heading) && !has_constant_norm(signals, i)) continue;
    is_explained[i] = is_found[i] = true;
    found.push_back(&signals[i]);
  }
  if (found.empty()) return;
  std::size_t rows = 0;
  Index first = 0;
  for (const Jumps& here : jumps)
    if (here.are_of(is_found) && is_flip(here) && rows++ == 0) first = here.row;
  const Signal& signal = *found.front();
  notes.push_back(fmt::format(
      "{}: {} {} the sign, {:.3g} to {:.3g}{}: is it a quaternion, for which q and -q are the same attitude? use "
      "elements of its rotation matrix instead, in the log{}: 1 - 2 (q_y^2 + q_z^2), 2 (q_x q_y + q_w q_z), ...",
      samples.place(first), quoted(found), found.size() == 1 ? "changes" : "change", signal.x[first - 1],
      signal.x[first], how_many(rows), are_measured ? " and in flight" : ""));
}

void note_changed_places(const Samples& samples, const std::vector<Signal>& signals, const std::vector<Jumps>& jumps,
                         std::vector<bool>& is_explained, Notes& notes) {
  constexpr double kSame = 0.1, kAtRest = 0.05;
  const std::vector<std::size_t> all = count_jumps(jumps, signals.size());
  std::vector<std::size_t> changes(signals.size(), 0), moving(signals.size(), 0), partner(signals.size(), 0);
  /// Returns the signal whose previous value signal i has now; signals.size(): none.
  const auto from = [&](const Jumps& here, std::size_t i) {
    const Signal& s = signals[i];
    for (const std::size_t other : here.signals)
      if (other != i && signals[other].column->unit == s.column->unit &&
          std::abs(s.x[here.row] - signals[other].x[here.row - 1]) <= kSame * std::abs(s.step(here.row)))
        return other;
    return signals.size();
  };
  const auto is_change = [&](const Jumps& here) {
    return here.signals.size() > 1 &&
           std::ranges::all_of(here.signals, [&](std::size_t i) { return from(here, i) < signals.size(); });
  };
  for (const Jumps& here : jumps) {
    if (!is_change(here)) continue;
    for (const std::size_t i : here.signals) {
      const Signal& s = signals[i];
      ++changes[i];
      partner[i] = from(here, i);
      // When a motor commutates, the current moves to the next phase and leaves 0, which is not an exchange.
      if (std::abs(s.x[here.row]) > kAtRest * s.range && std::abs(s.x[here.row - 1]) > kAtRest * s.range) ++moving[i];
    }
  }
  std::vector<const Signal*> found;
  std::vector<bool> is_found(signals.size(), false);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    if (is_explained[i] || changes[i] < 2 || !are_most(changes[i], all[i]) || 2 * moving[i] < changes[i]) continue;
    if (!has_many_sizes((signals[i].x - signals[partner[i]].x).cwiseAbs())) continue;
    is_found[i] = true;
    found.push_back(&signals[i]);
  }
  if (found.size() < 2) return;
  for (std::size_t i = 0; i < signals.size(); ++i) is_explained[i] = is_explained[i] || is_found[i];
  std::size_t rows = 0;
  Index first = 0;
  for (const Jumps& here : jumps)
    if (here.are_of(is_found) && is_change(here) && rows++ == 0) first = here.row;
  notes.push_back(
      fmt::format("{}: {} change places{}: does the order of a list change, as in a JointState? write each value under "
                  "its own name in the log",
                  samples.place(first), quoted(found), how_many(rows)));
}

}  // namespace

void note_jumps(const LogSchema& schema, const std::vector<LogFile>& logs, const std::vector<std::vector<LogRun>>& runs,
                Notes& notes) {
  const Samples samples = samples_of(logs, runs);
  if (samples.size() < 3) return;
  std::set<std::string> outputs;
  for (const auto* columns : {&schema.outputs, &schema.states}) {
    const std::vector<Signal> signals = signals_of(*columns, logs, runs, samples.size());
    const std::vector<Jumps> jumps = jumps_of(samples, signals);
    std::vector<bool> is_explained(signals.size(), false);
    // A measured state is checked as an output.
    for (std::size_t i = 0; i < signals.size(); ++i) is_explained[i] = outputs.contains(signals[i].column->heading);
    note_quaternions(samples, signals, jumps, columns == &schema.outputs, is_explained, notes);
    note_changed_places(samples, signals, jumps, is_explained, notes);
    for (std::size_t i = 0; i < signals.size(); ++i)
      if (!is_explained[i]) note_wraps(samples, signals[i], notes);
    for (const Signal& signal : signals) outputs.insert(signal.column->heading);
  }
}

}  // namespace nlo::trainer

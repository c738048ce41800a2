// SPDX-License-Identifier: MIT
#include "trainer/data/guess/log_guess.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/base/nearest_name.h"
#include "trainer/config/value.h"
#include "trainer/data/clock_text.h"
#include "trainer/data/csv_format.h"
#include "trainer/data/guess/column_numbers.h"
#include "trainer/data/guess/heading.h"
#include "trainer/data/guess/role_word.h"
#include "trainer/data/guess/split_files.h"

namespace nlo::trainer {
namespace {

/// Finds the roles of the columns of one log.
class Guess {
 public:
  Guess(std::vector<CsvTable> tables, const LogHints& hints, GuessedLog& log)
      : tables_(std::move(tables)), hints_(hints), log_(log) {
    const auto is_ambiguous = [&](const std::string& heading) {
      return std::ranges::any_of(tables_, [&](const CsvTable& table) { return table.is_ambiguous(heading); });
    };
    for (const std::string& heading : tables_.front().headings()) {
      if (!is_ambiguous(heading)) {
        headings_.push_back(heading);
      } else if (std::ranges::find(twice_, heading) == twice_.end()) {
        twice_.push_back(heading);
        log_.notes.push_back(
            fmt::format("several columns have the heading \"{}\", so none of them is read: rename them", heading));
      }
    }
  }

  void make() {
    for (const std::string& heading : headings_) {
      parsed_.push_back(read_heading(heading, headings_));
      // A unit below a heading is treated like a unit in brackets at the end of the heading.
      if (const std::string unit = tables_.front().unit(heading); !unit.empty())
        parsed_.back().unit = read_heading(fmt::format("{} [{}]", heading, unit), headings_).unit;
    }
    find_named_clock();
    for (std::size_t i = 0; i < headings_.size(); ++i)
      numbers_.push_back(ColumnNumbers::of(tables_, headings_[i], is_command(parsed_[i])));
    if (log_.clock.heading.empty()) find_clock_by_numbers();
    for (std::size_t i = 0; i < headings_.size(); ++i)
      if (headings_[i] != log_.clock.heading) add(i);
    apply_hints();
    if (hints_.states.empty() && hints_.outputs.empty()) decide_by_exclusion();
    for (GuessedColumn& column : log_.columns)
      if (column.why.empty()) column.why = "neither its heading nor its numbers show its role";
    derive_velocities();
    note_missing();
    name_apart();
  }

 private:
  bool is_given(const std::vector<std::string>& hints, const GuessedColumn& column) const {
    return std::ranges::any_of(hints, [&](const std::string& h) { return h == column.heading || h == column.name; });
  }

  bool is_command(const Heading& heading) const {
    return role_word(heading, parsed_).role == ColumnRole::kInput ||
           std::ranges::any_of(hints_.inputs, [&](const std::string& h) {
             return h == heading.name || read_heading(h, headings_).name == heading.name;
           });
  }

  void note_missing() {
    for (const GuessedColumn& column : log_.columns)
      if (!column.missing.empty() && (column.role != ColumnRole::kIgnored || !column.is_decided))
        log_.notes.push_back(
            fmt::format("{}: these values are treated as missing; if they are readings, delete missing = {}",
                        column.where_missing, show_cells(column.missing)));
  }

  /// Makes column `i` the clock. Throws codegen::Error if it is not a clock.
  void take_clock(std::size_t i, const std::string& why) {
    std::vector<std::string> notes;
    const ColumnNumbers stamps = ColumnNumbers::of_clock(tables_, headings_[i], notes);
    log_.notes.insert(log_.notes.end(), notes.begin(), notes.end());
    const TimeUnit unit =
        stamps.is_text() ? TimeUnit{"s", 1.0, "times of day, read in s"} : time_unit(parsed_[i], stamps);
    const ColumnNumbers::Steps steps = stamps.steps();
    log_.clock = {
        headings_[i],         unit.name, steps.median * unit.seconds, steps.deviation, steps.duration * unit.seconds,
        why + "; " + unit.why};
  }

  /// Finds a clock by name before all columns are in memory as numbers, because the check of a clock needs as much
  /// memory.
  void find_named_clock() {
    for (std::size_t i = 0; i < headings_.size(); ++i) {
      if (!is_time_word(parsed_[i]) || is_half_stamp(parsed_[i], parsed_)) continue;
      try {
        return take_clock(i, "its heading, and it increases");
      } catch (const codegen::Error& error) {
        log_.notes.push_back(
            fmt::format("\"{}\" is named like a time but cannot be the clock: {}", headings_[i], error.what()));
      }
    }
  }

  void find_clock_by_numbers() {
    for (std::size_t i = 0; i < headings_.size(); ++i) {
      if (is_half_stamp(parsed_[i], parsed_)) continue;
      if (numbers_[i].increases() && numbers_[i].is_even() && !numbers_[i].counts_rows())
        return take_clock(i, "it increases by even steps");
      if (!numbers_[i].is_numeric() && read_clock_text(numbers_[i].first_cell()))
        return take_clock(i, "its cells are times");
    }
    note_half_stamps();
    log_.clock.period_s = hints_.period_s;
  }

  void note_half_stamps() {
    std::vector<std::string> halves;
    for (std::size_t i = 0; i < headings_.size(); ++i)
      if (is_half_stamp(parsed_[i], parsed_)) halves.push_back(fmt::format("\"{}\"", headings_[i]));
    if (!halves.empty())
      log_.notes.push_back(
          fmt::format("{} contain one time stamp in two columns, but a clock must be one column: write seconds + 1e-9 "
                      "* nanoseconds into one column, with all digits",
                      fmt::join(halves, " and ")));
  }

  /// Returns the reason why a column that is not the clock is a time nevertheless; empty: it is not a time.
  std::string why_other_time(std::size_t i) const {
    if (is_half_stamp(parsed_[i], parsed_)) return "a part of a stamp";
    static const std::vector<std::string> kUnits = {"s", "ms", "us", "ns"};
    const bool has_time_unit = std::ranges::find(kUnits, parsed_[i].unit) != kUnits.end();
    // A column "T" that does not increase is a temperature.
    const bool is_time = is_time_word(parsed_[i]) && (parsed_[i].name.size() > 1 || numbers_[i].increases());
    if (!is_time && !(has_time_unit && numbers_[i].increases())) return "";
    return log_.clock.heading.empty() ? "named like a time, but not a clock"
                                      : fmt::format("a time, but \"{}\" is the clock", log_.clock.heading);
  }

  void add(std::size_t i) {
    GuessedColumn& column = log_.columns.emplace_back();
    const ColumnNumbers& numbers = numbers_[i];
    column.heading = headings_[i];
    column.name = parsed_[i].name;
    column.unit = parsed_[i].unit;
    column.low = numbers.low();
    column.high = numbers.high();
    column.spacing = numbers.spacing();
    column.period_s = static_cast<double>(column.spacing) * log_.clock.period_s;
    column.missing = numbers.missing();
    column.where_missing = numbers.where_missing();
    if (!numbers.is_numeric()) {
      column.why = fmt::format("its cells are not numbers: \"{}\"", numbers.first_cell());
      return;
    }
    const FullTurn turn = full_turn(numbers, column.unit);
    column.wrap = turn.wrap;
    column.jumps = turn.jumps;
    if (column.unit.empty()) column.unit = turn.unit;
    if (numbers.is_constant()) {
      column.why = "all its values are equal";
      return;
    }
    if (numbers.counts_rows()) {
      column.why = "it counts rows";
      return;
    }
    for (std::size_t other = 0; other < i; ++other)
      if (numbers.is_copy_of(numbers_[other])) {
        column.why = fmt::format("a copy of \"{}\"", headings_[other]);
        return;
      }
    if (column.why = why_other_time(i); !column.why.empty()) return;
    const RoleWord word = role_word(parsed_[i], parsed_);
    column.role = word.role;
    column.is_decided = word.role != ColumnRole::kIgnored || word.is_aside;
    column.why = word.why;
  }

  void apply_hints() {
    const auto apply = [&](const std::vector<std::string>& hints, ColumnRole role, const char* option) {
      for (const std::string& hint : hints) {
        const auto found = std::ranges::find_if(
            log_.columns, [&](const GuessedColumn& c) { return hint == c.heading || hint == c.name; });
        if (found == log_.columns.end()) refuse(hint, option);
        if (found->low > found->high)
          throw codegen::Error(fmt::format("{} {}: the cells of the column are not numbers", option, hint));
        const std::string why = fmt::format("{} names it", option);
        if (role == ColumnRole::kState && is_given(hints_.outputs, *found)) {
          both_.push_back(*found);  // a state that is also measured is listed twice
          both_.back().role = role;
          both_.back().why = why;
          continue;
        }
        found->role = role;
        found->is_decided = true;
        found->why = why;
      }
    };
    apply(hints_.outputs, ColumnRole::kOutput, "--outputs");
    apply(hints_.inputs, ColumnRole::kInput, "--inputs");
    apply(hints_.states, ColumnRole::kState, "--states");
    const auto not_named = [&](const std::vector<std::string>& hints, ColumnRole role) {
      for (GuessedColumn& column : log_.columns)
        if (!hints.empty() && column.role == role && !is_given(hints, column) && !column.why.ends_with("names it")) {
          column.role = ColumnRole::kIgnored;
          column.why = "the options name other columns";
        }
    };
    not_named(hints_.outputs, ColumnRole::kOutput);
    not_named(hints_.inputs, ColumnRole::kInput);
    not_named(hints_.states, ColumnRole::kState);
    if (hints_.states.empty() || hints_.outputs.empty()) return;
    for (GuessedColumn& column : log_.columns)
      if (!column.is_decided) column.is_decided = true, column.why = "no option names it";
  }

  [[noreturn]] void refuse(const std::string& hint, const char* option) const {
    std::vector<std::string> known;
    for (const GuessedColumn& column : log_.columns) known.push_back(column.heading);
    const std::string nearest = nearest_name(hint, known);
    throw codegen::Error(fmt::format("{} {}: there is no such column; {}", option, hint,
                                     nearest.empty() ? fmt::format("there are: {}", fmt::join(known, ", "))
                                                     : fmt::format("did you mean \"{}\"?", nearest)));
  }

  /// Decides roles by exclusion. If some columns are named as sensors and none as truth, the rest is truth, and the
  /// other way round. Two kinds of the remaining columns are sensors, as long as another column remains to be
  /// estimated: a slow sensor, which has a value in every n-th row while other columns have one in every row; and a
  /// column of a quantity that is usually measured.
  void decide_by_exclusion() {
    const bool sensors = log_.count(ColumnRole::kOutput) > 0, truth = log_.count(ColumnRole::kState) > 0;
    if (sensors == truth) return;
    const bool has_dense =
        std::ranges::any_of(log_.columns, [](const GuessedColumn& c) { return !c.is_decided && c.spacing == 0; });
    const auto sensed = [&](const GuessedColumn& column) {
      return sensed_quantity(
          parsed_[static_cast<std::size_t>(std::ranges::find(headings_, column.heading) - headings_.begin())]);
    };
    const bool leaves_truth =
        std::ranges::any_of(log_.columns, [&](const GuessedColumn& c) { return !c.is_decided && sensed(c).empty(); });
    for (GuessedColumn& column : log_.columns) {
      if (column.is_decided) continue;
      column.is_decided = true;
      if (sensors && has_dense && column.spacing > 0) {
        column.role = ColumnRole::kOutput;
        column.why = fmt::format("CHECK: it has a value in every {}th row, other columns in every row: a slow sensor?",
                                 column.spacing);
        continue;
      }
      if (const std::string quantity = sensed(column); sensors && !quantity.empty()) {
        column.is_decided = leaves_truth;
        if (leaves_truth) column.role = ColumnRole::kOutput;
        column.why = fmt::format("CHECK: {} names a quantity that sensors usually measure", quantity);
        continue;
      }
      column.role = sensors ? ColumnRole::kState : ColumnRole::kOutput;
      column.why = sensors ? "CHECK: other columns are named as sensors, but this one is not: the truth?"
                           : "CHECK: other columns are named as truth, but this one is not: a sensor?";
    }
  }

  /// Adds velocities of the measurements by a non-causal filter, for a log without any truth.
  void derive_velocities() {
    if (log_.count(ColumnRole::kState) > 0 || !both_.empty() || !log_.undecided().empty() || !hints_.states.empty())
      return;
    std::vector<GuessedColumn> derived;
    for (const GuessedColumn& column : log_.columns) {
      if (column.role != ColumnRole::kOutput || !(column.wrap > 0.0 || is_position(column.unit))) continue;
      GuessedColumn state;
      state.name = column.name + "_rate";
      state.unit = column.unit.empty() ? "" : column.unit + "/s";
      state.role = ColumnRole::kState;
      state.derivative_of = column.name;
      state.why =
          "the log has no truth: the derivative of this output, by a filter that also uses later rows of the log";
      state.low = 1.0;
      derived.push_back(std::move(state));
    }
    log_.columns.insert(log_.columns.end(), derived.begin(), derived.end());
  }

  /// Makes names unique. Two headings may give the same name, and a measured state is two columns.
  void name_apart() {
    for (GuessedColumn& state : both_) {
      const auto output = std::ranges::find(log_.columns, state.heading, &GuessedColumn::heading);
      output->name += "_measured";
      log_.columns.push_back(std::move(state));
    }
    for (std::size_t i = 0; i < log_.columns.size(); ++i) {
      const std::string name = log_.columns[i].name;
      int number = 2;
      const auto taken = [&] {
        return log_.columns[i].name == log_.clock.heading ||
               std::any_of(log_.columns.begin(), log_.columns.begin() + static_cast<std::ptrdiff_t>(i),
                           [&](const GuessedColumn& c) { return c.name == log_.columns[i].name; });
      };
      while (taken()) log_.columns[i].name = fmt::format("{}_{}", name, number++);
    }
  }

  std::vector<CsvTable> tables_;
  const LogHints& hints_;
  GuessedLog& log_;
  std::vector<std::string> headings_, twice_;  ///< headings once each, and headings that are left out
  std::vector<Heading> parsed_;
  std::vector<ColumnNumbers> numbers_;
  std::vector<GuessedColumn> both_;
};

/// Keeps the columns of the first file, in its order. Throws codegen::Error if another file lacks one of them. Adds a
/// note on the columns that only other files have.
void keep_common_headings(const std::vector<CsvTable>& tables, GuessedLog& log) {
  for (const CsvTable& table : tables)
    for (const std::string& heading : tables.front().headings())
      if (std::ranges::find(table.headings(), heading) == table.headings().end())
        throw codegen::Error(
            fmt::format("{}: has no column \"{}\", but {} has one: give logs of one rig, or give the log with the "
                        "fewest columns first",
                        table.file(), heading, tables.front().file()));
  for (const CsvTable& table : tables)
    for (const std::string& heading : table.headings())
      if (std::ranges::find(tables.front().headings(), heading) == tables.front().headings().end())
        log.notes.push_back(fmt::format("{}: its column \"{}\" is left out, because {} does not have it", table.file(),
                                        heading, tables.front().file()));
}

}  // namespace

std::size_t GuessedLog::count(ColumnRole role) const {
  return static_cast<std::size_t>(std::ranges::count(columns, role, &GuessedColumn::role));
}

std::vector<std::string> GuessedLog::undecided() const {
  std::vector<std::string> names;
  for (const GuessedColumn& column : columns)
    if (!column.is_decided) names.push_back(column.name);
  return names;
}

GuessedLog guess_log(const std::vector<std::string>& files, const LogHints& hints) {
  GuessedLog log;
  const LogFileSplit split = split_log_files(files, log.notes);
  log.directory = split.directory;
  log.train = split.train;
  log.validation = split.validation;
  log.test = split.test;
  std::vector<CsvTable> tables;
  for (const std::string& file : split.all) {
    std::string text = codegen::read_file(file);
    const CsvFormat format = guess_csv_format(text);
    if (tables.empty()) log.format = format;
    if (format.separator != log.format.separator || format.decimal != log.format.decimal)
      log.notes.push_back(
          fmt::format("{}: has other separators of cells or decimals than {}: it is read with its own separators", file,
                      tables.front().file()));
    tables.push_back(CsvTable::parse(std::move(text), file, format));
    log.rows += tables.back().rows();
  }
  keep_common_headings(tables, log);
  Guess(std::move(tables), hints, log).make();
  return log;
}

}  // namespace nlo::trainer

// SPDX-License-Identifier: MIT
#include "trainer/data/log_stamps.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string_view>

#include "codegen/base/error.h"
#include "trainer/base/printable.h"
#include "trainer/base/quantile.h"
#include "trainer/data/clock_text.h"
#include "trainer/data/time_stamps.h"

namespace nlo::trainer {
namespace {

using codegen::Error;
using Eigen::Index;
using Eigen::VectorXd;

constexpr double kDay_s = 86400.0;

/// The cells of a clock before any row is left out.
struct Readings {
  VectorXd stamps;  ///< numbers of the file; for times of day: seconds from midnight of the first date
  bool is_text = false;
  bool has_date = false;
};

Readings read_clock_texts(const CsvTable& table, const std::string& heading) {
  const std::vector<std::string_view> cells = table.cells(heading);
  Readings read{VectorXd(table.rows()), true, false};
  long first_day = 0;
  for (Index row = 0; row < table.rows(); ++row) {
    const std::string_view cell = cells[static_cast<std::size_t>(row)];
    const std::optional<ClockText> clock = read_clock_text(cell);
    if (row == 0 && clock) read.has_date = clock->has_date, first_day = clock->day;
    if (!clock || clock->has_date != read.has_date)
      throw Error(fmt::format(
          "{}:{}:{}: \"{}\" is not a time in the format of the first one, \"{}\": correct the row or delete it",
          table.file(), table.line(row), ascii(heading), ascii(cell.substr(0, 40)),
          ascii(cells.front().substr(0, 40))));
    read.stamps[row] = kDay_s * static_cast<double>(clock->day - first_day) + clock->seconds;
  }
  return read;
}

Readings read_clock(const CsvTable& table, const std::string& heading) {
  const std::string_view first = table.rows() > 0 ? table.cell(heading, 0) : std::string_view();
  if (read_clock_text(first)) return read_clock_texts(table, heading);
  try {
    return {table.column(heading), false, false};
  } catch (const Error& error) {
    if (first.find(':') == std::string_view::npos) throw;
    throw Error(
        fmt::format("{}; write times in seconds, or as 10:11:12.345, or as 2026-11-20T10:11:12.345Z", error.what()));
  }
}

/// Removes repeated and wrong stamps from the clock, and finds where it goes back.
class Cleaner {
 public:
  Cleaner(const CsvTable& table, const std::string& heading, const Readings& read)
      : table_(table),
        heading_(heading),
        read_(read),
        name_(std::filesystem::path(table.file()).filename().string()),
        time_(read.stamps.size()) {
    std::vector<double> rises;
    rises.reserve(static_cast<std::size_t>(read.stamps.size()));
    for (Index k = 1; k < read.stamps.size(); ++k)
      if (const double step = read.stamps[k] - read.stamps[k - 1]; step > 0.0) rises.push_back(step);
    if (!rises.empty()) usual_ = value_at_rank_of(rises, 0.5);
  }

  void clean(LogStamps& result) {
    for (Index row = 0; row < time_.size(); row = next_) {
      next_ = row + 1;
      time_[row] = read_.stamps[row] + shift_;
      take(row, result);
    }
    refuse_no_clock(result);
    note(result);
    result.time_s.resize(static_cast<Index>(result.rows.size()));
    double put = 0.0;  // makes time increase at restarts
    std::size_t restart = 0;
    for (std::size_t k = 0; k < result.rows.size(); ++k) {
      const double now = time_[result.rows[k]];
      if (restart < result.restarts.size() && result.restarts[restart] == static_cast<Index>(k)) {
        put += time_[result.rows[k - 1]] + usual_ - now;
        ++restart;
      }
      result.time_s[static_cast<Index>(k)] = now + put;
    }
  }

 private:
  /// Returns true for a usual step over `rows` rows, a few of which may be lost.
  bool is_usual(double step, Index rows = 1) const {
    return step > 0.0 && step <= (kGapPeriods + static_cast<double>(rows)) * usual_;
  }

  void take(Index row, LogStamps& result) {
    std::vector<Index>& kept = result.rows;
    if (kept.empty()) return kept.push_back(row);
    const double step = time_[row] - time_[kept.back()];
    if (step > 0.0) return kept.push_back(row);
    if (step == 0.0) return repeat(row, kept.back());
    if (goes_on(row, step)) return kept.push_back(row);
    const bool run_begins = !result.restarts.empty() && result.restarts.back() + 1 == static_cast<Index>(kept.size());
    if (kept.size() == 1 || (!run_begins && is_usual(time_[row] - time_[kept[kept.size() - 2]], 2))) {
      wrong_.push_back(kept.back());
      kept.back() = row;
      return;
    }
    const Index fits = next_that_fits(row, time_[kept.back()]);
    if (fits > row) {
      for (Index k = row; k < fits; ++k) wrong_.push_back(k);
      next_ = fits;
      return;
    }
    result.restarts.push_back(static_cast<Index>(kept.size()));
    kept.push_back(row);
  }

  void repeat(Index row, Index first) {
    repeated_.push_back(row);
    if (!table_.same_cells(row, first)) ++with_other_readings_;
  }

  /// Returns true if time continues although the stamp decreases: at midnight (no date), or after a counter overflow.
  bool goes_on(Index row, double step) {
    const auto add = [&](double turn) {
      shift_ += turn;
      time_[row] += turn;
      return true;
    };
    if (read_.is_text) return !read_.has_date && step < -0.5 * kDay_s && add(kDay_s);
    constexpr auto kTurns = std::to_array<double>({0x1p16, 0x1p32});
    for (const double turn : kTurns)
      if (read_.stamps[row] < turn && read_.stamps[row] - step < turn &&
          read_.stamps[row] == std::round(read_.stamps[row]) && is_usual(step + turn))
        return add(turn);
    return false;
  }

  /// Returns the next row after `row` whose stamp follows `before` as usual; the end if `row` is the last one; `row` if
  /// there is none.
  Index next_that_fits(Index row, double before) const {
    constexpr Index kFew = 10;
    if (row + 1 == time_.size()) return row + 1;
    for (Index k = row + 1; k <= row + kFew && k < time_.size(); ++k)
      if (is_usual(read_.stamps[k] + shift_ - before, k - row + 1)) return k;
    return row;
  }

  std::string place(Index row) const { return fmt::format("{}:{}", name_, table_.line(row)); }
  std::string cell(Index row) const { return ascii(table_.cell(heading_, row).substr(0, 40)); }

  void refuse_no_clock(const LogStamps& result) const {
    const auto steps = static_cast<double>(time_.size() - 1);
    const std::size_t back = wrong_.size() + result.restarts.size();
    constexpr double kMostBack = 0.1, kMostRepeated = 0.2;
    const char* fix = "give another column role = \"time\", or none, and write [log] sample_period_s";
    if (result.rows.size() < 2 || static_cast<double>(back) > std::max(2.0, kMostBack * steps)) {
      Index first = 1;
      while (first + 1 < time_.size() && read_.stamps[first] > read_.stamps[first - 1]) ++first;
      const auto falls =
          time_.size() - 1 -
          (read_.stamps.tail(time_.size() - 1).array() > read_.stamps.head(time_.size() - 1).array()).count();
      throw Error(fmt::format(
          "{}:{}:{}: time does not increase in {} of {} steps, here from {} to {}: is this column the clock? {}",
          table_.file(), table_.line(first), ascii(heading_), falls, time_.size() - 1, cell(first - 1), cell(first),
          fix));
    }
    if (static_cast<double>(with_other_readings_) > kMostRepeated * steps)
      throw Error(fmt::format(
          "{}:{}:{}: {:.0f} % of the rows have the stamp of the row before but other readings, so the clock is too "
          "coarse; {}",
          table_.file(), table_.line(repeated_.front()), ascii(heading_), 100.0 * with_other_readings_ / steps, fix));
  }

  void note(LogStamps& result) const {
    if (!result.restarts.empty()) {
      const Index row = result.rows[static_cast<std::size_t>(result.restarts.front())];
      const std::size_t count = result.restarts.size();
      result.notes.push_back(
          fmt::format("{}: the clock goes back ({} follows {}), so a new run begins there{}. If it is one run with a "
                      "wrong clock, leave the time column out and write [log] sample_period_s",
                      place(row), cell(row), cell(row - 1),
                      count == 1 ? "" : fmt::format(" (the first of {} such places)", count)));
    }
    if (!wrong_.empty())
      result.notes.push_back(fmt::format(
          "{}: the stamp {} does not fit its neighbours: the row is left out{}", place(wrong_.front()),
          cell(wrong_.front()), wrong_.size() == 1 ? "" : fmt::format(" (the first of {} such rows)", wrong_.size())));
    if (!repeated_.empty())
      result.notes.push_back(
          fmt::format("{}: the stamp {} equals that of the row before: only the first of these rows is kept{}",
                      place(repeated_.front()), cell(repeated_.front()),
                      repeated_.size() == 1 ? "" : fmt::format(" (the first of {} such rows)", repeated_.size())));
  }

  const CsvTable& table_;
  const std::string& heading_;
  const Readings& read_;
  std::string name_;
  VectorXd time_;  ///< time of each row so far, continued over midnights and overflows
  double usual_ = 0.0, shift_ = 0.0;
  Index next_ = 0;
  std::vector<Index> repeated_, wrong_;
  double with_other_readings_ = 0.0;
};

}  // namespace

LogStamps read_stamps(const CsvTable& table, const std::string& heading, double unit_s) {
  const Readings read = read_clock(table, heading);
  LogStamps result;
  result.is_text = read.is_text;
  Cleaner(table, heading, read).clean(result);
  const double seconds = read.is_text ? 1.0 : unit_s, first = result.time_s[0];
  result.resolution_s = stamp_resolution(result.time_s) * seconds;
  if (!read.is_text) result.start_s = first * seconds;
  result.time_s = (result.time_s.array() - first) * seconds;
  return result;
}

}  // namespace nlo::trainer

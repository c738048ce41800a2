// SPDX-License-Identifier: MIT
#include "trainer/replay/explain_flight.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "codegen/base/error.h"
#include "trainer/replay/flight_times.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr Index kEnough = 8;        // rows to the bit that speak for a cause
constexpr Index kFewest = 3;        // where the log ends before
constexpr Index kLatestStart = 64;  // rows that may have been logged before the observer's first step

class Explanation {
 public:
  Explanation(const FlightLog& log, double sample_period_s, const FlownExport& flown, const MatrixXd& answers,
              const FlightDifference& difference)
      : log_(log),
        flown_(flown),
        answers_(answers),
        compare_(log, flown.single()),
        row_(difference.row),
        rows_(log.given.cols()),
        times_(log, sample_period_s, row_) {}

  /// The estimates stand a row late (they were logged before the step), or early.
  std::string shifted() const {
    if (rows_ <= kFewest) return "";
    if (compare_.agreeing(1, answers_, 0, rows_) == rows_ - 1)
      return "the estimates are logged a row late: log them after step(), beside the readings that it was given";
    if (compare_.agreeing(0, answers_, 1, rows_) == rows_ - 1)
      return "the estimates are logged a row early: log them beside the readings that step() was given";
    return "";
  }

  std::string started_otherwise() const {
    if (flown_.settles() && begins(row_, kWarmStart))
      return row_ == 0 ? "the observer began with warm_start(): replay with --warm-start"
                       : fmt::format("warm_start() was called in line {}: replay the log from there with --warm-start",
                                     line(row_));
    if (row_ > 0 && begins(row_, kReset))
      return fmt::format(
          "the observer was reset before line {} (a restart, reset(), or a memory fault that it detected): replay the "
          "log from there as another",
          line(row_));
    for (Index first = 1; row_ == 0 && first < std::min(kLatestStart, rows_ - kFewest); ++first)
      if (begins(first, kReset))
        return fmt::format("the observer's first step was that of line {}: delete the lines before it", line(first));
    return "";
  }

  /// step() was given something else in this row.
  std::string given_otherwise() const {
    const double nothing = std::numeric_limits<double>::quiet_NaN();
    const Index outputs = log_.given.rows() - kGivenReading;
    MatrixXd given = log_.given;
    given.col(row_).tail(outputs).setConstant(nothing);
    if (agrees(given, row_, 0))
      return fmt::format(
          "in line {} the observer was given no reading (a gate held it back, or it came too late): log what step() "
          "was "
          "given, nan for nothing",
          line(row_));
    for (Index j = 0; j < outputs; ++j) {
      given.col(row_) = log_.given.col(row_);
      given(kGivenReading + j, row_) = nothing;
      if (outputs > 1 && agrees(given, row_, 0))
        return fmt::format("in line {} the observer was given no {}: log what step() was given, nan for nothing",
                           line(row_), log_.readings[static_cast<std::size_t>(j)].name);
    }
    given = without(row_);
    if (agrees(given, row_ + 1, -1))
      return fmt::format("line {} was logged and not stepped (a duplicate, or an overrun): delete it", line(row_));
    if ((log_.given.row(kGivenCommand).array() != kStep).any()) {
      given = log_.given;
      given.row(kGivenCommand).setZero();
      if (agrees(given, row_, 0))
        return "step() was called without dt: leave the column dt out, or its cells empty where it was";
    }
    return "";
  }

  /// The log's time goes on by another step there: one of a dt that was not logged, or of rows that were not.
  std::string told_by_time() const {
    Index row = row_;
    while (row > 0 && !times_.off(row) && nothing_compared(row - 1)) --row;
    if (!times_.off(row)) return "";
    MatrixXd given = log_.given;
    for (Index k = row; k < rows_; ++k)
      if (times_.off(k)) given(kGivenCommand, k) = kStepOverDt, given(kGivenDt, k) = log_.since_s[k];
    const Index count = times_.lost(row);
    const double by_dt = left_of(flown_.run(given)), by_steps = count > 0 && row == row_ ? left_with(count) : 1.0;
    const std::string where = fmt::format("line {}, where the time goes on by {:.6g} s", line(row), log_.since_s[row]);
    if (by_dt < (count == 0 ? kMuchSmaller : kRounding))  // one long step and several short ones differ little
      return fmt::format(
          "step() was given a dt in {}: with it the difference is {:.2g} of what it is; log the column dt", where,
          by_dt);
    if (count == 0) return "";
    return fmt::format(
        "{} before {}, {} sample periods{}: log every step", steps_lost(count), where, times_.passed(row),
        by_steps < 1.0 ? fmt::format(" (with means in between the difference is {:.2g} of what it is)", by_steps) : "");
  }

  /// A step that the log lacks: with the mean of its neighbours in its place the difference is much smaller.
  std::string lost() const {
    if (row_ == 0) return "";
    for (Index count = 1; count <= 3; ++count) {
      if (const double left = left_with(count); left < kMuchSmaller)
        return fmt::format(
            "{} before line {}: with the mean of the neighbours in {} place the difference is {:.2g} of "
            "what it is",
            steps_lost(count), line(row_), count == 1 ? "its" : "their", left);
    }
    return "";
  }

  /// Readings that were printed with too few digits make about as much of a difference.
  std::string rounded_readings() const {
    std::vector<std::string> coarse;
    MatrixXd given = log_.given;
    for (std::size_t j = 0; j < log_.readings.size(); ++j) {
      const LoggedColumn& reading = log_.readings[j];
      if (reading.digits == 0 || reading.digits >= compare_.digits_needed()) continue;
      coarse.push_back(fmt::format("{} ({})", reading.name, reading.digits));
      for (Index row = 0; row < rows_; ++row)  // up and down, without a period of its own
        given(kGivenReading + static_cast<Index>(j), row) +=
            (row * (row + 3 + static_cast<Index>(j)) / 2 % 2 == 0 ? 1.0 : -1.0) * reading.half_digit[row];
    }
    if (coarse.empty()) return "";
    const MatrixXd moved = flown_.run(given);
    double spread = 0.0;
    FlightComparison of_replay(log_, flown_.single());
    for (const LoggedColumn& column : log_.answers) {
      if (column.answer < kAnswerEstimate) continue;
      const double range = answers_.row(column.answer).maxCoeff() - answers_.row(column.answer).minCoeff();
      if (range > 0.0)
        spread =
            std::max(spread, (moved.row(column.answer) - answers_.row(column.answer)).cwiseAbs().maxCoeff() / range);
    }
    constexpr double kTimes = 4.0;
    if (compare_.largest(answers_, 0, rows_) > kTimes * spread) return "";
    return fmt::format(
        "the readings have too few digits, {}: half a unit of the last one moves the estimates as much; print them "
        "with "
        "%.{}g, and no more can be said of this log",
        fmt::join(coarse, ", "), compare_.digits_needed());
  }

  bool small() const { return compare_.largest(answers_, 0, rows_) < kRounding; }

  std::string in_general() const {
    const Index quarter = std::max<Index>(1, (rows_ - row_) / 4);
    const double early = compare_.largest(answers_, row_, std::min(rows_, row_ + quarter));
    const double late = compare_.largest(answers_, rows_ - quarter, rows_);
    constexpr double kDecayed = 0.25;
    if (rows_ - row_ > 2 * kEnough && late < kDecayed * early)
      return row_ == 0 ? "the observer was running before the log begins: the difference dies out; log from its first "
                         "step"
                       : fmt::format(
                             "something happened once before or in line {}, and the difference dies out: a "
                             "lost row, another reading than the logged one, restore(), a flipped bit",
                             line(row_));
    if (small())
      return "other arithmetic: the policy fast has the bits of its compiler, flags and processor (--target cpp "
             "--compiler \"...\" on the same), -ffast-math has any; what flies with --target c99, single, or the "
             "deterministic policy is replayed to the bit everywhere";
    return row_ == 0
               ? "another model than this one flew, or its readings are not these (another unit, sign, order, or a "
                 "filter before step())"
               : fmt::format("from line {} on another model flew, or it was given other readings than the log's",
                             line(row_));
  }

 private:
  static constexpr double kRounding = 1e-4;    // of the range of a column
  static constexpr double kMuchSmaller = 0.2;  // what is left of a difference whose cause was found

  int line(Index row) const { return log_.lines[static_cast<std::size_t>(row)]; }

  bool enough(Index agreeing, Index from) const {
    return agreeing >= kFewest && agreeing >= std::min(kEnough, rows_ - from);
  }

  /// A fresh observer that takes `row` first answers what was logged from there on.
  bool begins(Index row, double command) const {
    MatrixXd given = log_.given.middleCols(row, std::min(kEnough, rows_ - row));
    given(kGivenCommand, 0) += command;
    return enough(compare_.agreeing(row, flown_.run(given), 0, kEnough), row);
  }

  /// The log's rows from `from` on are what `given` answers, `moved` columns further on.
  bool agrees(const MatrixXd& given, Index from, Index moved) const {
    const MatrixXd until = given.leftCols(std::min(given.cols(), from + moved + kEnough));
    return enough(compare_.agreeing(from, flown_.run(until), from + moved, kEnough), from);
  }

  bool nothing_compared(Index row) const {
    return std::all_of(log_.answers.begin(), log_.answers.end(),
                       [row](const LoggedColumn& column) { return std::isnan(column.values[row]); });
  }

  static std::string steps_lost(Index count) {
    return count == 1 ? "a step of the observer is lost" : fmt::format("{} steps of the observer are lost", count);
  }

  /// What part of the difference is left, by `answers` to another flight.
  double left_of(const MatrixXd& answers) const {
    const Index until = std::min(rows_, row_ + kEnough);
    return compare_.largest(answers, row_, until) / compare_.largest(answers_, row_, until);
  }

  /// With so many steps before it, of means of its neighbours.
  double left_with(Index count) const {
    MatrixXd given(log_.given.rows(), rows_ + count);
    given.leftCols(row_) = log_.given.leftCols(row_);
    given.rightCols(rows_ - row_) = log_.given.rightCols(rows_ - row_);
    for (Index i = 0; i < count; ++i) {
      const double part = static_cast<double>(i + 1) / static_cast<double>(count + 1);
      given.col(row_ + i) = (1.0 - part) * log_.given.col(row_ - 1) + part * log_.given.col(row_);
      given(kGivenCommand, row_ + i) = kStep;
    }
    MatrixXd moved = answers_;
    moved.rightCols(rows_ - row_) = flown_.run(given).rightCols(rows_ - row_);
    return left_of(moved);
  }

  MatrixXd without(Index row) const {
    MatrixXd given(log_.given.rows(), rows_ - 1);
    given.leftCols(row) = log_.given.leftCols(row);
    given.rightCols(rows_ - 1 - row) = log_.given.rightCols(rows_ - 1 - row);
    return given;
  }

  const FlightLog& log_;
  const FlownExport& flown_;
  const MatrixXd& answers_;
  FlightComparison compare_;
  Index row_, rows_;
  StepTimes times_;
};

/// Another export of the model that gives all of the log. `small`: the fast policy may, too, which takes seconds to
/// compile.
std::string other_arithmetic(const FlightLog& log, const codegen::Model& model, const Flown& arithmetic, bool small) {
  for (const char* target : {"c99", "cpp"})
    for (const char* scalar : {"float", "double", "int16"}) {
      if ((target == arithmetic.target && scalar == arithmetic.scalar) || (target == std::string("cpp") && !small))
        continue;
      Flown flown;
      flown.target = target;
      flown.scalar = scalar;
      try {
        const FlownExport other(model, flown);
        if (!FlightComparison(log, other.single()).first(other.run(log.given)))
          return fmt::format("another export flew: with {} all is the same", other.name());
      } catch (const codegen::Error&) {  // it has no such export, or nothing here compiles it
      }
    }
  return "";
}

}  // namespace

std::string explain_flight(const FlightLog& log, const codegen::Model& model, const Flown& arithmetic,
                           const FlownExport& flown, const MatrixXd& answers, const FlightDifference& difference) {
  const Explanation why(log, model.sample_period_s, flown, answers, difference);
  std::string cause = why.shifted();
  if (cause.empty()) cause = why.started_otherwise();
  if (cause.empty()) cause = why.given_otherwise();
  if (cause.empty()) cause = why.told_by_time();
  if (cause.empty()) cause = why.rounded_readings();
  if (cause.empty()) cause = other_arithmetic(log, model, arithmetic, why.small());
  if (cause.empty() && !why.small()) cause = why.lost();
  return cause.empty() ? why.in_general() : cause;
}

}  // namespace nlo::trainer

// SPDX-License-Identifier: MIT
#include "trainer/data/impossible_values.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "trainer/base/number_text.h"
#include "trainer/config/value.h"
#include "trainer/data/log_outliers.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kHuge = 1e30;

template <std::size_t N>
bool is_among(const std::array<double, N>& values, double value) {
  return std::ranges::find(values, value) != values.end();
}

/// Returns true for -99, -999.9, -9999: loggers write them for "no value", and sensors hardly reach them.
bool is_nines(double value) {
  constexpr auto kNines = std::to_array<double>({-99, -999, -9999, -99999, -999999, -9999999});
  for (const double scale : {1.0, 10.0, 100.0, 1000.0})
    if (is_among(kNines, std::round(value * scale)) && std::abs(value * scale - std::round(value * scale)) < 1e-6)
      return value <= -99.0;
  return false;
}

/// Returns true if `value` is the end of the range of a converter or of an integer of 16 or 32 bits (the latter also in
/// tenths to thousandths), or a number such as 9999.
bool is_end(double value) {
  constexpr auto kEnds = std::to_array<double>({999, 9999, 99999, 999999, 1023, 2047, 4095, 8191, 16383, -2048, -8192});
  constexpr auto kIntegers =
      std::to_array<double>({32767, -32767, -32768, 65535, 2147483647, -2147483648.0, 4294967295.0});
  if (is_among(kEnds, value)) return true;
  for (const double scale : {1.0, 10.0, 100.0, 1000.0})
    if (is_among(kIntegers, std::round(value * scale)) &&
        std::abs(value * scale - std::round(value * scale)) < 1e-9 * std::abs(value * scale))
      return true;
  return false;
}

template <class Visit>
void for_each_value(const std::vector<VectorXd>& signals, const std::vector<double>& without, const Visit& visit) {
  for (const VectorXd& x : signals)
    for (const double value : x)
      if (std::isfinite(value) && std::ranges::find(without, value) == without.end()) visit(value);
}

/// The largest and the smallest value, and their neighbours.
struct Ends {
  double low = std::numeric_limits<double>::infinity(), next_low = low;
  double high = -low, next_high = -low;
};

Ends ends_of(const std::vector<VectorXd>& signals, const std::vector<double>& without) {
  Ends ends;
  for_each_value(signals, without, [&](double value) {
    if (value < ends.low)
      ends.next_low = ends.low, ends.low = value;
    else if (value > ends.low && value < ends.next_low)
      ends.next_low = value;
    if (value > ends.high)
      ends.next_high = ends.high, ends.high = value;
    else if (value < ends.high && value > ends.next_high)
      ends.next_high = value;
  });
  return ends;
}

/// Occurrences of one value.
struct Occurrences {
  Index count = 0, stretches = 0, longest = 0;  ///< longest: rows of the longest stretch

  bool are_brief() const { return longest <= kOutlierRows; }
};

Occurrences occurrences_of(const std::vector<VectorXd>& signals, double value) {
  Occurrences found;
  for (const VectorXd& x : signals) {
    Index stretch = 0;
    for (const double each : x) {
      stretch = each == value ? stretch + 1 : 0;
      if (stretch > 0) ++found.count;
      if (stretch == 1) ++found.stretches;
      found.longest = std::max(found.longest, stretch);
    }
  }
  return found;
}

/// Returns true if a column has many values. A valve that is open or shut has few.
bool has_many_values(const std::vector<VectorXd>& signals, const std::vector<double>& without) {
  constexpr std::size_t kMany = 20;
  std::set<double> seen;
  for_each_value(signals, without, [&](double value) {
    if (seen.size() < kMany) seen.insert(value);
  });
  return seen.size() == kMany;
}

/// Judges the outermost value of a column, after the impossible values that were already found have been removed.
class Judge {
 public:
  Judge(const std::vector<VectorXd>& signals, bool is_command) : signals_(signals), is_command_(is_command) {
    for_each_value(signals, {}, [this](double) { ++all_; });
  }

  /// Returns true if `value` is impossible. `next`: the next value; `other_end`: the value at the other end.
  bool is_impossible(const std::vector<double>& found, double value, double next, double other_end) const {
    if (!std::isfinite(next)) return false;  // there is no other value
    if (std::abs(value) > kHuge) return true;
    constexpr double kFar = 0.3, kVeryFar = 3.0, kRare = 0.2, kVeryRare = 0.05;
    constexpr Index kPlaces = 3;
    const double range = std::abs(next - other_end), away = std::abs(value - next);
    if (!(away > kFar * range)) return false;
    const bool very_far = away > kVeryFar * range;
    if (is_nines(value) && very_far) return true;
    if (!is_nines(value) && !is_end(value) && (is_command_ || !very_far)) return false;
    std::vector<double> without = found;
    without.push_back(value);
    if (!has_many_values(signals_, without)) return false;
    if (is_nines(value)) return true;
    const Occurrences at = occurrences_of(signals_, value);
    const double share = static_cast<double>(at.count) / static_cast<double>(all_);
    if (is_end(value)) return at.are_brief() || (very_far && share < kRare);
    return at.are_brief() && at.stretches >= kPlaces && share < kVeryRare;
  }

  Index all() const { return all_; }

 private:
  const std::vector<VectorXd>& signals_;
  bool is_command_;
  Index all_ = 0;
};

}  // namespace

ImpossibleValues impossible_values(const std::vector<VectorXd>& signals, bool is_command) {
  constexpr std::size_t kMost = 8;
  const Judge judge(signals, is_command);
  ImpossibleValues found;
  found.all = judge.all();
  std::vector<std::pair<Index, double>> counted;
  while (found.values.size() < kMost) {
    const Ends ends = ends_of(signals, found.values);
    found.low = ends.low;
    found.high = ends.high;
    double value = std::numeric_limits<double>::quiet_NaN();
    if (judge.is_impossible(found.values, ends.high, ends.next_high, ends.low)) value = ends.high;
    if (judge.is_impossible(found.values, ends.low, ends.next_low, ends.high)) value = ends.low;
    if (std::isnan(value)) break;
    counted.emplace_back(occurrences_of(signals, value).count, value);
    found.count += counted.back().first;
    if (2 * found.count >= found.all) return {};
    found.values.push_back(value);
  }
  std::ranges::stable_sort(counted, std::greater<>(), [](const auto& each) { return each.first; });
  for (std::size_t i = 0; i < counted.size(); ++i) found.values[i] = counted[i].second;
  if (found.values.empty()) return found;
  for (std::size_t file = 0; file < signals.size(); ++file) {
    const auto& x = signals[file];
    const auto first = std::find(x.begin(), x.end(), found.values.front());
    if (first == x.end()) continue;
    found.file = file;
    found.row = first - x.begin();
    break;
  }
  return found;
}

std::vector<std::string> as_cells(const ImpossibleValues& found) {
  std::vector<std::string> cells;
  for (const double value : found.values) cells.push_back(shortest_text(value));
  return cells;
}

std::string to_text(const ImpossibleValues& found, const std::string& heading, const std::string& file, int line) {
  return fmt::format("{}:{}: \"{}\" is {} here and in {:.2g} % of its rows; elsewhere it is from {:.4g} to {:.4g}",
                     file, line, heading, fmt::join(as_cells(found), " or "),
                     100.0 * static_cast<double>(found.count) / static_cast<double>(found.all), found.low, found.high);
}

std::vector<std::string> note_impossible_values(const LogSchema& schema, const std::vector<LogFile>& logs,
                                                std::vector<std::string>& notes) {
  std::vector<std::string> headings;
  std::set<std::string> seen;
  for (const auto* columns : {&schema.outputs, &schema.states, &schema.inputs})
    for (const LogColumn& column : *columns) {
      const std::string& heading = column.heading;
      if (!seen.insert(heading).second) continue;
      std::vector<VectorXd> signals;
      for (const LogFile& log : logs) {
        signals.push_back(log.column(heading));
        if (const auto empty = log.empty.find(heading); empty != log.empty.end())
          signals.back()(empty->second).setConstant(std::numeric_limits<double>::quiet_NaN());
      }
      const ImpossibleValues found = impossible_values(signals, columns == &schema.inputs);
      if (found.values.empty()) continue;
      headings.push_back(heading);
      const LogFile& log = logs[found.file];
      notes.push_back(fmt::format("{}: if these are not readings, write missing = {} at the column",
                                  to_text(found, heading, log.name, log.lines[static_cast<std::size_t>(found.row)]),
                                  show_cells(as_cells(found))));
    }
  return headings;
}

}  // namespace nlo::trainer

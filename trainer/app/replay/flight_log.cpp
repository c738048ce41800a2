// SPDX-License-Identifier: MIT
#include "trainer/app/replay/flight_log.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/base/printable.h"
#include "trainer/data/csv.h"
#include "trainer/data/csv_format.h"

namespace nlo::trainer {
namespace {

using codegen::Error;
using Eigen::Index;

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr std::array kStatusWords = {"OK", "CLAMPED", "HELD", "STALE", "OUT_OF_RANGE", "REJECTED", "DIVERGED", "RESET"};

/// Format of a cell: number of digits from the first that is not 0, and of digits behind the point.
struct Printed {
  int significant = 0, decimals = 0, exponent = 0;
  bool has_exponent = false;
};

Printed printed(std::string_view cell, char decimal) {
  Printed result;
  bool behind = false, leading = true;
  for (std::size_t i = 0; i < cell.size(); ++i) {
    const char c = cell[i];
    if (c == 'e' || c == 'E') {
      const std::size_t from = i + (i + 1 < cell.size() && cell[i + 1] == '+' ? 2 : 1);
      std::from_chars(cell.data() + from, cell.data() + cell.size(), result.exponent);
      result.has_exponent = true;
      break;
    }
    if (c == decimal) behind = true;
    if (c < '0' || c > '9') continue;
    leading = leading && c == '0';
    result.significant += leading ? 0 : 1;
    result.decimals += behind ? 1 : 0;
  }
  return result;
}

/// Finds the place of the last digit in a column's cells. If all cells have the same number of decimals (%.6f), this
/// number is the place. Otherwise (%.9g, which omits zeros at the end) the longest cell tells the number of significant
/// digits.
void find_digits(LoggedColumn& column, const std::vector<std::string_view>& cells, char decimal) {
  std::vector<Printed> all;
  bool fixed = true, first = true;
  int decimals = 0;
  for (const std::string_view cell : cells) {
    all.push_back(printed(cell, decimal));
    const Printed& now = all.back();
    if (std::isnan(column.values[static_cast<Index>(all.size()) - 1])) continue;
    column.digits = std::max(column.digits, now.significant);
    fixed = fixed && !now.has_exponent && (first || now.decimals == decimals);
    decimals = now.decimals;
    first = false;
  }
  column.half_digit = Eigen::VectorXd::Zero(column.values.size());
  if (fixed && decimals == 0) {  // integers are not rounded
    column.digits = 0;
    return;
  }
  for (Index row = 0; row < column.values.size(); ++row) {
    const double value = std::abs(column.values[row]);
    if (std::isnan(value)) continue;
    const int place = fixed          ? -decimals
                      : value == 0.0 ? -std::numeric_limits<double>::max_exponent10
                                     : static_cast<int>(std::floor(std::log10(value))) - column.digits + 1;
    column.half_digit[row] = 0.5 * std::pow(10.0, place);
  }
}

double number_of_bits(std::string_view cell, std::size_t bytes, const std::string& where) {
  std::uint64_t bits = 0;
  const auto [end, status] = std::from_chars(cell.data() + 2, cell.data() + cell.size(), bits, 16);
  if (status != std::errc() || end != cell.data() + cell.size() || (bytes == 4 && bits > 0xffffffffU))
    throw Error(fmt::format("{}: \"{}\" is not the {} bytes of a number: print a float by %08lx, a double by %016llx",
                            where, ascii(cell), bytes));
  return bytes == 4 ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)))
                    : std::bit_cast<double>(bits);
}

/// Returns the number of a status or truth value by name: "HELD", "kHeld", "van_der_pol_HELD", "true".
double number_of_word(std::string_view cell) {
  std::string word(cell.substr(cell.rfind('_') == std::string_view::npos ? 0 : cell.rfind('_') + 1));
  if (word.size() > 1 && word[0] == 'k') word.erase(0, 1);
  for (char& c : word) c = static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
  if (word == "TRUE" || word == "FALSE") return word == "TRUE" ? 1.0 : 0.0;
  const auto found = std::find(kStatusWords.begin(), kStatusWords.end(), word);
  return found == kStatusWords.end() ? kNothing : static_cast<double>(found - kStatusWords.begin());
}

class Reader {
 public:
  Reader(const std::string& file, const std::string& text, std::size_t scalar_bytes,
         const std::vector<std::pair<std::string, std::string>>& headings)
      : format_(guess_csv_format(text)),
        table_(CsvTable::parse(text, file, format_)),
        scalar_bytes_(scalar_bytes),
        renamed_(headings) {}

  const CsvTable& table() const { return table_; }
  bool has(const std::string& name) const {
    const auto& all = table_.headings();
    return std::find(all.begin(), all.end(), heading(name)) != all.end() || heading(name) != name;
  }
  std::string heading(const std::string& name) const {
    for (const auto& [of, heading] : renamed_)
      if (of == name) return heading;
    return name;
  }

  LoggedColumn column(const std::string& name, Index answer = 0) const {
    LoggedColumn column{name, heading(name), {}, {}, 0, answer};
    const std::vector<std::string_view> cells = table_.cells(column.heading);
    const auto starts = [&](const char* with) {
      return std::any_of(cells.begin(), cells.end(), [&](std::string_view cell) { return cell.starts_with(with); });
    };
    if (starts("0x")) {
      column.values.setConstant(static_cast<Index>(cells.size()), kNothing);
      column.half_digit.setZero(column.values.size());
      for (Index row = 0; row < column.values.size(); ++row)
        if (const std::string_view cell = cells[static_cast<std::size_t>(row)]; cell.starts_with("0x"))
          column.values[row] = number_of_bits(cell, scalar_bytes_,
                                              fmt::format("{}:{}:{}", table_.file(), table_.line(row), column.heading));
      return column;
    }
    std::vector<Index> empty;
    column.values = table_.column(column.heading, empty);
    find_digits(column, cells, format_.decimal);
    return column;
  }

  /// Reads a column of statuses or truth values, as numbers or names.
  LoggedColumn word(const std::string& name, Index answer) const {
    LoggedColumn column{name, heading(name), {}, {}, 0, answer};
    const std::vector<std::string_view> cells = table_.cells(column.heading);
    column.half_digit.setZero(static_cast<Index>(cells.size()));
    if (std::none_of(cells.begin(), cells.end(), [](auto cell) { return !std::isnan(number_of_word(cell)); })) {
      std::vector<Index> empty;
      column.values = table_.column(column.heading, empty);
      return column;
    }
    column.values.resize(static_cast<Index>(cells.size()));
    for (Index row = 0; row < column.values.size(); ++row) {
      const std::string_view cell = cells[static_cast<std::size_t>(row)];
      column.values[row] = number_of_word(cell);
      if (std::isnan(column.values[row]) && !cell.empty())
        throw Error(fmt::format("{}:{}:{}: \"{}\" is none of {}, true and false", table_.file(), table_.line(row),
                                column.heading, ascii(cell), fmt::join(kStatusWords, ", ")));
    }
    return column;
  }

 private:
  CsvFormat format_;
  CsvTable table_;
  std::size_t scalar_bytes_;
  const std::vector<std::pair<std::string, std::string>>& renamed_;
};

void check_names(const std::vector<std::pair<std::string, std::string>>& headings, const codegen::Model& model) {
  std::vector<std::string> known = {"dt", "status", "in_domain"};
  for (const auto* channels : {&model.outputs, &codegen::inputs(model)})
    for (const codegen::Channel& channel : *channels) known.push_back(channel.name);
  for (const codegen::Channel& state : model.states) known.push_back(state.name + "_hat");
  for (const auto& [name, heading] : headings)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw Error(fmt::format("--column {}={}: a flight of \"{}\" has nothing called {}; there are {}", name, heading,
                              model.name, name, fmt::join(known, ", ")));
}

}  // namespace

std::string status_word(double status) {
  return status >= 0.0 && status < static_cast<double>(kStatusWords.size())
             ? kStatusWords[static_cast<std::size_t>(status)]
             : "?";
}

FlightLog read_flight(const std::string& file, const codegen::Model& model, std::size_t scalar_bytes,
                      const std::vector<std::pair<std::string, std::string>>& headings) {
  check_names(headings, model);
  const Reader reader(file, codegen::read_file(file), scalar_bytes, headings);
  FlightLog log;
  log.file = file;
  const Index rows = reader.table().rows();
  for (Index row = 0; row < rows; ++row) log.lines.push_back(reader.table().line(row));

  for (const codegen::Channel& output : codegen::measured_channels(model))
    log.readings.push_back(reader.column(output.name));
  for (const codegen::Channel& input : codegen::inputs(model)) log.readings.push_back(reader.column(input.name));
  log.given.setZero(kGivenReading + static_cast<Index>(log.readings.size()), rows);
  for (std::size_t j = 0; j < log.readings.size(); ++j)
    log.given.row(kGivenReading + static_cast<Index>(j)) = log.readings[j].values;
  if (reader.has("dt")) {
    log.given.row(kGivenDt) = reader.column("dt").values;
    for (Index row = 0; row < rows; ++row) {
      const bool regular = std::isnan(log.given(kGivenDt, row));
      log.given(kGivenCommand, row) = regular ? kStep : kStepOverDt;
      if (regular) log.given(kGivenDt, row) = 0.0;
    }
  }

  for (std::size_t i = 0; i < model.states.size(); ++i) {
    const std::string name = model.states[i].name + "_hat";
    if (!reader.has(name))
      log.missing.push_back(name);
    else
      log.answers.push_back(reader.column(name, kAnswerEstimate + static_cast<Index>(i)));
  }
  if (log.answers.empty())
    throw Error(
        fmt::format("{}: no column {}: log the results of estimate(), or name the columns that hold them, --column {}="
                    "HEADING; there are {}",
                    file, fmt::join(log.missing, " or "), log.missing.front(),
                    ascii(fmt::format("{}", fmt::join(reader.table().headings(), ", ")))));
  if (reader.has("status")) log.answers.push_back(reader.word("status", kAnswerStatus));
  if (reader.has("in_domain")) log.answers.push_back(reader.word("in_domain", kAnswerInDomain));
  return log;
}

}  // namespace nlo::trainer

// SPDX-License-Identifier: MIT
#include "trainer/report/training_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/base/number_text.h"

namespace nlo::trainer {
namespace {

using codegen::Error;

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t start = 0;;) {
    const auto end = text.find(separator, start);
    parts.push_back(text.substr(start, end - start));
    if (end == text.npos) return parts;
    start = end + 1;
  }
}

double cell(std::string_view text, const std::string& name, std::size_t line) {
  if (text.empty() || text == "nan" || text == "inf" || text == "-inf") return std::numeric_limits<double>::quiet_NaN();
  if (const auto value = finite_number(text)) return *value;
  throw Error(fmt::format("{}:{}: \"{}\" is not a number", name, line, text));
}

}  // namespace

TrainingCurves parse_training_curves(std::string_view csv, const std::string& name) {
  std::vector<std::string_view> lines = split(csv, '\n');
  for (std::string_view& line : lines)
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  while (!lines.empty() && lines.back().empty()) lines.pop_back();
  if (lines.empty()) throw Error(fmt::format("{}: is empty; expected the metrics of a training run", name));

  const std::vector<std::string_view> headings = split(lines[0], ',');
  const auto rows = static_cast<Eigen::Index>(lines.size() - 1);
  Eigen::MatrixXd values(rows, static_cast<Eigen::Index>(headings.size()));
  for (std::size_t row = 1; row < lines.size(); ++row) {
    const auto cells = split(lines[row], ',');
    if (cells.size() != headings.size())
      throw Error(
          fmt::format("{}:{}: has {} cells where the headings name {}", name, row + 1, cells.size(), headings.size()));
    for (std::size_t i = 0; i < cells.size(); ++i)
      values(static_cast<Eigen::Index>(row - 1), static_cast<Eigen::Index>(i)) = cell(cells[i], name, row + 1);
  }
  const auto has = [&](std::string_view heading) {
    return std::find(headings.begin(), headings.end(), heading) != headings.end();
  };
  const auto column = [&](std::string_view heading) -> Eigen::VectorXd {
    if (!has(heading)) return Eigen::VectorXd::Constant(rows, std::numeric_limits<double>::quiet_NaN());
    return values.col(std::find(headings.begin(), headings.end(), heading) - headings.begin());
  };
  if (!has("step"))
    throw Error(fmt::format("{}:1: has no column \"step\"; expected the metrics of a training run", name));

  TrainingCurves curves{column("step"),
                        column("elapsed_s"),
                        column("loss"),
                        column("train_rmse"),
                        column("validation_rmse"),
                        column("learning_rate"),
                        {}};
  for (int i = 1; has(fmt::format("lambda_{}_re", i)); ++i) {
    Eigen::VectorXcd curve(rows);
    curve.real() = column(fmt::format("lambda_{}_re", i));
    curve.imag() = column(fmt::format("lambda_{}_im", i));
    curves.eigenvalues.push_back(std::move(curve));
  }
  return curves;
}

TrainingCurves read_training_curves(const std::string& path) {
  return parse_training_curves(codegen::read_file(path), path);
}

}  // namespace nlo::trainer

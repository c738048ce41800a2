// SPDX-License-Identifier: MIT
// Compiled with -ffp-contract=off, for the reason in run_random.cpp.
#include "trainer/plants/logged_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "codegen/base/error.h"
#include "trainer/base/number_text.h"
#include "trainer/data/csv.h"

namespace nlo::trainer {
namespace {

constexpr double kMostPeriods = 1e6;  // between two rows of a log

/// Returns the inputs at `time_s` within the log, on the straight line between the rows around it.
Eigen::VectorXd value_at(const LoggedInputs& log, double time_s) {
  const double* begin = log.time_s.data();
  const auto after = std::upper_bound(begin, begin + log.time_s.size(), time_s) - begin;
  if (after >= log.time_s.size()) return log.values.col(log.time_s.size() - 1);
  const double share = (time_s - log.time_s(after - 1)) / (log.time_s(after) - log.time_s(after - 1));
  return log.values.col(after - 1) + share * (log.values.col(after) - log.values.col(after - 1));
}

}  // namespace

LoggedInputs read_logged_inputs(const ExcitationConfig& excitation, const SimulationConfig& simulation) {
  if (std::ranges::find(excitation.kinds, InputSignal::kLog) == excitation.kinds.end()) return {};
  const CsvTable table = CsvTable::read(excitation.log);
  if (table.rows() < 2)
    throw codegen::Error(fmt::format("{}: a log of inputs needs at least two rows", excitation.log));
  LoggedInputs log;
  if (excitation.log_time.empty()) {
    log.time_s = Eigen::VectorXd::LinSpaced(table.rows(), 0.0, static_cast<double>(table.rows() - 1)) *
                 simulation.sample_period_s;
  } else {
    log.time_s = table.column(excitation.log_time);
    log.time_s.array() -= double(log.time_s(0));
    const double longest_s = kMostPeriods * simulation.sample_period_s;
    for (Eigen::Index row = 1; row < table.rows(); ++row) {
      const double step_s = log.time_s(row) - log.time_s(row - 1);
      if (!(step_s > 0.0))
        throw codegen::Error(fmt::format("{}:{}: {} does not increase; remove the row, or leave log_time out",
                                         excitation.log, table.line(row), excitation.log_time));
      if (!(step_s <= longest_s))
        throw codegen::Error(
            fmt::format("{}:{}: {} is {} s after the row before, but at most {} s ({:g} sample periods) are allowed; "
                        "remove the row",
                        excitation.log, table.line(row), excitation.log_time, shortest_text(step_s),
                        shortest_text(longest_s), kMostPeriods));
    }
  }
  log.values.resize(static_cast<Eigen::Index>(excitation.log_columns.size()), table.rows());
  for (std::size_t j = 0; j < excitation.log_columns.size(); ++j) {
    const Eigen::VectorXd column = table.column(excitation.log_columns[j]);
    for (Eigen::Index row = 0; row < table.rows(); ++row)
      if (!(column(row) >= excitation.low[j] && column(row) <= excitation.high[j]))
        throw codegen::Error(
            fmt::format("{}:{}: {} is {}, but [excitation] limits this input to {} to {}; widen low and high",
                        excitation.log, table.line(row), excitation.log_columns[j], shortest_text(column(row)),
                        shortest_text(excitation.low[j]), shortest_text(excitation.high[j])));
    log.values.row(static_cast<Eigen::Index>(j)) = column.transpose();
  }
  return log;
}

Eigen::MatrixXd stretch_of(const LoggedInputs& log, double start_s, double sample_period_s, Eigen::Index samples) {
  Eigen::MatrixXd inputs(log.values.rows(), samples);
  const double duration_s = log.time_s(log.time_s.size() - 1);
  for (Eigen::Index k = 0; k < samples; ++k) {
    const double at = start_s + static_cast<double>(k) * sample_period_s;
    inputs.col(k) = value_at(log, at <= duration_s ? at : at - duration_s * std::floor(at / duration_s));
  }
  return inputs;
}

}  // namespace nlo::trainer

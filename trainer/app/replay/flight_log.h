// SPDX-License-Identifier: MIT
// A recorded flight from a CSV: the inputs and the answers of an observer at each step.
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "codegen/model/model.h"

namespace nlo::trainer {

/// A column with the precision of its cells.
struct LoggedColumn {
  std::string name, heading;
  Eigen::VectorXd values;      ///< NaN: nothing was logged in this row
  Eigen::VectorXd half_digit;  ///< half a unit of each cell's last digit; 0: the cell is exact
  int digits = 0;              ///< significant digits of the longest cell; 0: integers, names or bits
  Eigen::Index answer = 0;     ///< row of the answers that it is compared with
};

/// Rows of the answers (flown_export.h); estimates follow.
enum Answer : Eigen::Index { kAnswerStatus, kAnswerInDomain, kAnswerEstimate };
/// Rows of the given values; outputs and inputs follow.
enum Given : Eigen::Index { kGivenCommand, kGivenDt, kGivenReading };
/// Bits of a value in the row kGivenCommand, which name the functions that the call ran. step(y) has no bit.
inline constexpr double kStep = 0, kStepOverDt = 1, kReset = 2, kWarmStart = 4;

struct FlightLog {
  std::string file;
  std::vector<int> lines;              ///< line in the file for each row
  Eigen::MatrixXd given;               ///< (2 + outputs + inputs) x N, a column for each call
  std::vector<LoggedColumn> readings;  ///< outputs, then inputs
  std::vector<LoggedColumn> answers;   ///< estimates first, then status and in_domain if they were logged
  std::vector<std::string> missing;    ///< estimates that were not logged
};

/// Reads `file` for `model`: a column for each output and input under its name, NAME_hat for each state, and if the log
/// has them dt (argument of step(y, dt); an empty cell: step(y)), status and in_domain. Other columns are ignored.
/// `headings`: other headings for these names. Cells: decimals, nothing or NaN, or 0x and the bits of a float of
/// `scalar_bytes`; statuses also by name. Throws codegen::Error with the fix.
FlightLog read_flight(const std::string& file, const codegen::Model& model, std::size_t scalar_bytes,
                      const std::vector<std::pair<std::string, std::string>>& headings);

/// Returns the name of a status in a log and its number; "?" for an unknown one.
std::string status_word(double status);

}  // namespace nlo::trainer

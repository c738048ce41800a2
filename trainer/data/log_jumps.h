// SPDX-License-Identifier: MIT
// Finds columns that jump between neighbouring rows although the plant does not: angles without a wrap, quaternions
// whose sign changes, columns that change places. An observer would learn the mean of both sides.
#pragma once

#include <string>
#include <vector>

#include "trainer/data/log_file.h"
#include "trainer/data/log_schema.h"

namespace nlo::trainer {

/// Checks the outputs, then the states. Columns with a wrap and derivatives are left out. Adds a note for
///   an angle        a column that jumps from end to end of its range while it moves the other way, at least twice, by
///   a usual full turn (2 pi, 360, 1, counts); if its unit is rad or deg, any jump of half a turn
///   a quaternion    columns that jump to their opposite: with a constant norm; or two in the same rows, at least
///   twice; or one with a heading of quaternions
///   changed places  columns that jump to the previous value of another column, at least twice
/// Each note has file and line of the first jump, their number, and the remedy.
void note_jumps(const LogSchema& schema, const std::vector<LogFile>& logs, const std::vector<std::vector<LogRun>>& runs,
                std::vector<std::string>& notes);

}  // namespace nlo::trainer

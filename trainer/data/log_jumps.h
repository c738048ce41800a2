// SPDX-License-Identifier: MIT
// Columns that jump between neighbouring rows although nothing in the plant does: angles without a wrap, quaternions
// whose sign changes, columns that change places. An observer would learn the mean of both sides.
#pragma once

#include <string>
#include <vector>

#include "trainer/data/log_file.h"
#include "trainer/data/log_schema.h"

namespace nlo::trainer {

/// Looks at outputs and at states, each group by itself; columns with a wrap and derivatives are left out. A note for
///   an angle        a column that jumps from end to end of its range while it moves the other way, twice or more, by a
///                   usual full turn (2 pi, 360, 1, counts); where its unit is rad or deg, any jump of half a turn
///   a quaternion    columns that jump to their opposite: with a constant norm; or two in the same rows, twice or
///                   more; or one whose heading says it
///   changed places  columns that jump to the previous value of another column, twice or more
/// Each note names file and line of the first jump, how many there are, and the remedy.
void note_jumps(const LogSchema& schema, const std::vector<LogFile>& logs, const std::vector<std::vector<LogRun>>& runs,
                std::vector<std::string>& notes);

}  // namespace nlo::trainer

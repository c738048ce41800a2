// SPDX-License-Identifier: MIT
#pragma once

namespace nlo::trainer {

/// From here on, an allocation that fails ends the program with exit code 1 and one line on stderr. It does not throw,
/// because not all code could handle the exception: Eigen 3.4 frees a matrix before it allocates its successor and then
/// frees it again, some functions of the standard library are noexcept and allocate, and a parser would report that its
/// input file is wrong. No data is lost, because files are written whole or not at all.
void end_where_memory_ends();

}  // namespace nlo::trainer

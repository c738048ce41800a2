// SPDX-License-Identifier: MIT
#pragma once

namespace nlo::trainer {

/// From here on an allocation that fails ends the program: exit 1 and one line on stderr. It is no exception, because
/// code would have to survive it: Eigen 3.4 frees a matrix before it allocates its successor and then frees
/// it again, some of the standard library's functions are noexcept and allocate, and a parser blames the file that it
/// reads. Nothing is lost: files are written whole or not at all.
void end_where_memory_ends();

}  // namespace nlo::trainer

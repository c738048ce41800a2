// SPDX-License-Identifier: MIT
// The runtime is written in C++20. An older language gets one error that says what to do, and the compiler stops there:
// each header begins with this one, directly or through another.
#pragma once

#if __cplusplus < 202002L
#error "nlo needs C++20: compile with -std=c++20 or -std=gnu++20 (CMake: link nlo::runtime, which asks for it)"
// No file has this name: to miss it ends the compilation, where hundreds of errors would follow.
#define NLO_STOP "nlo/stopped_by_the_error_above"
#include NLO_STOP
#endif

// SPDX-License-Identifier: MIT
// Included at the end of an S-function, like Simulink's own file. It runs the S-function.
#include "tests/codegen/shims/simulink/run_sfunction.h"

// SPDX-License-Identifier: MIT
// Included at the end of an S-function, as Simulink's own file is: what runs it.
#include "tests/codegen/shims/simulink/run_sfunction.h"

// SPDX-License-Identifier: MIT
#include "trainer/base/version.h"

namespace nlo::trainer {

const char* const kVersion = NLO_VERSION;

}  // namespace nlo::trainer

// SPDX-License-Identifier: MIT
// Adds pairs with little damping for the resonances of a plant. The forms of mode_banks.h forget within a period, but
// the state of a resonator depends on its inputs many periods ago.
#pragma once

#include <functional>

#include "trainer/choose/mode_banks.h"

namespace nlo::trainer {

/// Adds pairs re +- i im to `bank`, one after the other. A search over frequency, and then over frequency and damping,
/// places each where it lowers the expected error most. Ends if another pair would lower the error by less than a
/// tenth, or would make more than `most_rows` rows.
///   longest_s  longest time constant -1 / re
///   log_error  logarithm of the expected error with a bank
ModeBank with_resonances(const ModeBank& bank, double sample_period_s, double longest_s, int most_rows,
                         const std::function<double(const ModeBank&)>& log_error);

}  // namespace nlo::trainer

// SPDX-License-Identifier: MIT
// Lightly damped pairs for the resonances of a plant. The forms of mode_banks.h forget within a period; the state of a
// resonator depends on what drove it many periods ago.
#pragma once

#include <functional>

#include "trainer/choose/mode_banks.h"

namespace nlo::trainer {

/// Adds pairs re +- i im to `bank`, one after the other: each stands where it lowers the expected error most, by a
/// search over frequency and then over frequency and damping. Ends where another pair would lower it by less than a
/// tenth, or would make more than `most_rows` rows.
///   longest_s  no time constant -1 / re is longer
///   log_error  logarithm of the expected error with a bank
ModeBank with_resonances(const ModeBank& bank, double sample_period_s, double longest_s, int most_rows,
                         const std::function<double(const ModeBank&)>& log_error);

}  // namespace nlo::trainer

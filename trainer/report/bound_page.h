// SPDX-License-Identifier: MIT
// bound.html: Proposition 2 of one model as a self-contained page: the trade-off between speed and noise, the
// constants.
#pragma once

#include <string>

#include "trainer/bounds/bound_study.h"

namespace nlo::trainer {

/// The page. Without a working gnuplot it says so in place of the plots.
std::string bound_page(const BoundReport& report, const std::string& gnuplot = "gnuplot");

}  // namespace nlo::trainer

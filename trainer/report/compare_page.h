// SPDX-License-Identifier: MIT
// A comparison as a page that stands by itself.
#pragma once

#include <string>

#include "trainer/compare/compare_study.h"

namespace nlo::trainer {

std::string compare_page(const Comparison& comparison, const std::string& gnuplot = "gnuplot");

}  // namespace nlo::trainer

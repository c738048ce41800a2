// SPDX-License-Identifier: MIT
// A search as a page that stands by itself: what was tried, what was found.
#pragma once

#include <string>

#include "trainer/sweep/search_text.h"

namespace nlo::trainer {

std::string search_page(const SearchStory& story, const std::string& gnuplot = "gnuplot");

}  // namespace nlo::trainer

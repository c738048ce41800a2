// SPDX-License-Identifier: MIT
// Results as self-contained pages. Without a working gnuplot a page has a note in place of its plots.
#pragma once

#include <string>

#include "trainer/app/sweep/search_text.h"
#include "trainer/judge/compare/study.h"

namespace nlo::trainer {

/// compare.html: observers and filters under many conditions.
std::string compare_page(const Study& study, const std::string& gnuplot = "gnuplot");

/// auto.html: trials and result of a search.
std::string search_page(const SearchStory& story, const std::string& gnuplot = "gnuplot");

}  // namespace nlo::trainer

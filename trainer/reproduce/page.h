// SPDX-License-Identifier: MIT
// Writes reproduction.html: every section compares the paper's numbers with ours.
#pragma once

#include <string>

#include "trainer/reproduce/run.h"

namespace nlo::trainer::reproduction {

/// Returns a self-contained page, without links to files, scripts or the network.
std::string page_html(const Request& request, const Result& result, const Workbench& bench,
                      const std::string& gnuplot = "gnuplot");

/// Returns a short text of the numbers for a terminal.
std::string summary_text(const Result& result);

}  // namespace nlo::trainer::reproduction

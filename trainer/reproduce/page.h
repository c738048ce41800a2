// SPDX-License-Identifier: MIT
// reproduction.html: every section with the paper's numbers beside ours.
#pragma once

#include <string>

#include "trainer/reproduce/run.h"

namespace nlo::trainer::reproduction {

/// One self-contained page: no link to a file, a script or the network.
std::string page_html(const Request& request, const Result& result, const Workbench& bench,
                      const std::string& gnuplot = "gnuplot");

/// The numbers in short, for a terminal.
std::string summary_text(const Result& result);

}  // namespace nlo::trainer::reproduction

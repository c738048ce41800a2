// SPDX-License-Identifier: MIT
// The few pieces of HTML that a report is made of.
#pragma once

#include <string>
#include <string_view>

#include "trainer/evaluation/text.h"

namespace nlo::trainer {

/// Text that stands for itself in HTML, in an element or an attribute.
std::string escaped(std::string_view text);

/// A table of plain text. The first cell names its row, lines between rows are left out. Columns of numbers do not
/// wrap; what follows a line break in a cell stands below, small.
std::string html_table(const Table& table);

/// A paragraph that stands out: something is missing or needs attention.
std::string note(const std::string& text);

/// The same in red: do not trust what follows.
std::string alarm(const std::string& text);

/// A whole document around `body`, with its style sheet: light and dark, screen and paper.
std::string html_page(std::string_view title, std::string_view body);

}  // namespace nlo::trainer

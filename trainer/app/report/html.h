// SPDX-License-Identifier: MIT
// The elements of HTML that a report needs. A page has text and figures in the order of reading. Its figures are
// collected while the text is written, drawn together by one run of gnuplot, and inserted.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "trainer/app/report/gnuplot.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {

/// Escapes text for an element or an attribute of HTML.
std::string escaped(std::string_view text);

/// Returns a table of plain text. The first cell is the name of its row; lines between rows are left out. Columns of
/// numbers do not wrap. The text after a line break in a cell is below, in small letters.
std::string html_table(const Table& table);

/// Returns a highlighted paragraph: something is missing or needs attention.
std::string note(const std::string& text);

/// Returns a note in red: do not trust this result.
std::string alarm(const std::string& text);

/// Returns a whole document around `body` with its style sheet, for light and dark screens and for paper.
std::string html_page(std::string_view title, std::string_view body);

class Page {
 public:
  void text(const std::string& html) { parts_.push_back({html, -1}); }
  void heading(const std::string& title);

  /// A figure without panels is left out.
  void figure(Figure figure);

  /// Returns all parts as HTML. Without a working `gnuplot`, one note replaces all figures.
  std::string html(const std::string& gnuplot = "gnuplot") const;

 private:
  struct Part {
    std::string html;
    int figure;  ///< index into figures_; -1: this part is text
  };
  std::vector<Part> parts_;
  std::vector<Figure> figures_;
};

}  // namespace nlo::trainer

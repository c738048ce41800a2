// SPDX-License-Identifier: MIT
// The few pieces of HTML that a report is made of.
// A page of text and figures in order of reading. Figures are collected while the text is laid out, drawn together by
// one run of gnuplot, then put in place.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "trainer/app/report/gnuplot.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {

/// Text that stands for itself in HTML, in an element or an attribute.
std::string escaped(std::string_view text);

/// A table of plain text. The first cell names its row, lines between rows are left out. Columns of numbers do not
/// wrap; the text after a line break in a cell is below, in small letters.
std::string html_table(const Table& table);

/// A paragraph that stands out: something is missing or needs attention.
std::string note(const std::string& text);

/// A note in red: do not trust this result.
std::string alarm(const std::string& text);

/// A whole document around `body`, with its style sheet: light and dark, screen and paper.
std::string html_page(std::string_view title, std::string_view body);

class Page {
 public:
  void text(const std::string& html) { parts_.push_back({html, -1}); }
  void heading(const std::string& title);

  /// A figure without panels is left out.
  void figure(Figure figure);

  /// All parts as HTML. Without a working `gnuplot` one note stands for all figures.
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

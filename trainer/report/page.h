// SPDX-License-Identifier: MIT
// A page of text and figures in order of reading. Figures are collected while the text is laid out, drawn together by
// one run of gnuplot, then put in place.
#pragma once

#include <string>
#include <vector>

#include "trainer/report/gnuplot.h"

namespace nlo::trainer {

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

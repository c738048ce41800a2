// SPDX-License-Identifier: MIT
#include "trainer/report/page.h"

#include <fmt/format.h>

#include <cstddef>
#include <utility>

#include "trainer/report/html.h"

namespace nlo::trainer {

void Page::heading(const std::string& title) {
  text(fmt::format("<h2>{}</h2>\n", escaped(title)));
}

void Page::figure(Figure figure) {
  if (figure.panels.empty()) return;
  parts_.push_back({"", static_cast<int>(figures_.size())});
  figures_.push_back(std::move(figure));
}

std::string Page::html(const std::string& gnuplot) const {
  const Drawing drawing = draw(figures_, gnuplot);
  std::string html;
  bool told = false;
  for (const Part& part : parts_) {
    if (part.figure < 0) {
      html += part.html;
    } else if (drawing.failure.empty()) {
      const auto index = static_cast<std::size_t>(part.figure);
      html += fmt::format("<figure{}>\n<div class=\"plot\">{}</div>\n<figcaption>{}</figcaption>\n</figure>\n",
                          figures_[index].width < 800 ? " class=\"narrow\"" : "", drawing.svgs[index],
                          escaped(figures_[index].caption));
    } else if (!told) {
      html += note(
          fmt::format("The plots are missing: {}. Install gnuplot (Debian: gnuplot-nox) and write the report again.",
                      drawing.failure));
      told = true;
    }
  }
  return html;
}

}  // namespace nlo::trainer

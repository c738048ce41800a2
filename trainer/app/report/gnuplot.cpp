// SPDX-License-Identifier: MIT
#include "trainer/app/report/gnuplot.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "codegen/base/child.h"
#include "codegen/base/temporary.h"
#include "trainer/app/report/gnuplot_script.h"
#include "trainer/app/report/svg_text.h"

namespace nlo::trainer {
namespace {

namespace fs = std::filesystem;

constexpr auto kPatience = std::chrono::seconds(60);

std::string file_text(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace

Eigen::VectorXd thinned(const Eigen::VectorXd& values, Eigen::Index points) {
  const Eigen::Index step = std::max<Eigen::Index>(1, (values.size() + points - 1) / points);
  return values(Eigen::seqN(0, (values.size() + step - 1) / step, step));
}

std::string figure_label(const Figure& figure) {
  std::vector<std::string> heights, widths, names;
  const auto note_once = [](std::vector<std::string>& known, const std::string& name) {
    if (!name.empty() && std::find(known.begin(), known.end(), name) == known.end()) known.push_back(name);
  };
  for (const Panel& panel : figure.panels) {
    note_once(heights, panel.heat_map ? panel.heat_map->label : panel.y_label);
    note_once(widths, panel.x_label);
    for (const Series& series : panel.series) note_once(names, series.title);
  }
  return fmt::format("{}{}{}{}{}", fmt::join(heights, ", "), heights.empty() || widths.empty() ? "" : " over ",
                     fmt::join(widths, ", "), names.empty() ? "" : ": ", fmt::join(names, ", "));
}

Drawing draw(const std::vector<Figure>& figures, const std::string& program) {
  Drawing drawing;
  if (figures.empty()) return drawing;
  std::optional<codegen::TemporaryFolder> made;
  try {
    made.emplace((fs::temp_directory_path() / "nlo-plots").string());
  } catch (const std::exception& error) {  // an Error, or an error of the file system
    drawing.failure = error.what();
    return drawing;
  }
  const fs::path directory = made->name();
  std::string script;
  bool written = true;
  for (std::size_t i = 0; i < figures.size(); ++i) script += figure_script(figures[i], i, directory, written);
  written = write_text(directory / "plot.gp", script) && written;
  drawing.failure = written ? codegen::run_child({program, "-d", "plot.gp"}, directory, kPatience)
                            : "the plots' data could not be written";
  if (!drawing.failure.empty()) return drawing;
  for (std::size_t i = 0; i < figures.size(); ++i) {
    drawing.svgs.push_back(inline_svg(file_text(directory / fmt::format("{}.svg", i)), figure_label(figures[i])));
    if (drawing.svgs.back().empty()) drawing.failure = fmt::format("{} drew nothing", program);
  }
  if (!drawing.failure.empty()) drawing.svgs.clear();
  return drawing;
}

}  // namespace nlo::trainer

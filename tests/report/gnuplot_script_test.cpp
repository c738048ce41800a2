// SPDX-License-Identifier: MIT
#include "trainer/app/report/gnuplot_script.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <regex>
#include <set>
#include <tuple>

#include "tests/support/scratch_directory.h"
#include "trainer/app/report/gnuplot.h"
#include "trainer/app/report/html.h"
#include "trainer/app/report/svg_text.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Contrast of two colours "#rrggbb" by WCAG 2, from 1 to 21.
double contrast(const std::string& a, const std::string& b) {
  const auto luminance = [](const std::string& colour) {
    double sum = 0.0;
    for (const auto& [at, share] : {std::pair{1, 0.2126}, {3, 0.7152}, {5, 0.0722}}) {
      const double c = std::stoi(colour.substr(static_cast<std::size_t>(at), 2), nullptr, 16) / 255.0;
      sum += share * (c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
    }
    return sum;
  };
  const auto [low, high] = std::minmax({luminance(a), luminance(b)});
  return (high + 0.05) / (low + 0.05);
}

/// Returns the colours of the style sheet by name, for light pages and for dark ones.
std::array<std::map<std::string, std::string>, 2> page_colours() {
  const std::string page = html_page("", "");
  const auto dark_from = page.find("prefers-color-scheme: dark");
  std::array<std::map<std::string, std::string>, 2> colours;
  static const std::regex kColour(R"(--([a-z]+): (#[0-9a-f]{6});)");
  for (std::sregex_iterator found(page.begin(), page.end(), kColour), end; found != end; ++found) {
    const bool dark = static_cast<std::size_t>(found->position()) > dark_from;
    for (std::size_t scheme = dark ? 1 : 0; scheme < 2; ++scheme) colours[scheme][(*found)[1]] = (*found)[2];
  }
  return colours;
}

TEST(Page, TextHasEnoughContrastInLightAndDark) {
  constexpr double kReadable = 4.5;  // WCAG 2, level AA
  EXPECT_NEAR(contrast("#000000", "#ffffff"), 21.0, 1e-9);
  EXPECT_LT(contrast("#777777", "#ffffff"), kReadable) << "control";
  for (const auto& colours : page_colours()) {
    for (const char* text : {"text", "soft", "accent", "warn", "good"})
      for (const char* ground : {"ground", "card"})
        EXPECT_GE(contrast(colours.at(text), colours.at(ground)), kReadable) << text << " on " << ground;
    for (const auto& [text, ground] : {std::pair{"warn", "outside"}, {"soft", "outside"}, {"text", "alarm"}})
      EXPECT_GE(contrast(colours.at(text), colours.at(ground)), kReadable) << text << " on " << ground;
  }
}

/// Returns the commands that draw one panel.
std::string script_of(Panel panel) {
  const ScratchDirectory directory;
  bool written = true;
  std::string script = figure_script({"", 400, 200, false, {std::move(panel)}}, 0, directory.path(), written);
  EXPECT_TRUE(written);
  return script;
}

TEST(Figure, HasTenColoursThatAreVisibleOnLightAndDark) {
  constexpr double kVisible = 3.0;  // WCAG 2, level for graphics
  Panel panel;
  for (int i = 0; i < 11; ++i)
    panel.series.push_back({"", Series::Style::kLine, i, Eigen::Vector2d(0, 1), Eigen::Vector2d(0, 1), {}});
  const std::string script = script_of(panel);
  std::vector<std::string> drawn;
  static const std::regex kLine(R"(lines lw 1.8 lc rgb '(#[0-9a-f]{6})')");
  for (std::sregex_iterator found(script.begin(), script.end(), kLine), end; found != end; ++found)
    drawn.push_back((*found)[1]);
  ASSERT_EQ(drawn.size(), 11U);
  EXPECT_EQ(std::set<std::string>(drawn.begin(), drawn.end()).size(), 10U);
  for (const std::string& colour : drawn)
    for (const auto& colours : page_colours()) EXPECT_GE(contrast(colour, colours.at("ground")), kVisible) << colour;
}

TEST(Figure, LabelsALogarithmicAxisThatContainsNoPowerOfTen) {
  Panel panel;
  panel.log_x = true;
  for (const auto& [low, high, tics] : {std::tuple{1700.0, 6800.0, "(2000, 5000)"},
                                        {300.0, 480.0, "(300, 400)"},
                                        {0.02, 0.3, "(0.02, 0.05, 0.1, 0.2)"},
                                        {0.01, 1000.0, "autofreq"},
                                        {0.0, 0.0, "autofreq"}}) {
    panel.x_low = low;
    panel.x_high = high;
    EXPECT_THAT(script_of(panel), HasSubstr(std::string("set xtics ") + tics + "\n")) << low;
  }
}

TEST(Figure, WidensTheMarginForLongNumbers) {
  Panel panel;
  panel.y_high = 1.0;
  EXPECT_THAT(script_of(panel), HasSubstr("set lmargin 9\n"));
  panel.y_low = 0.1219;
  panel.y_high = 0.1224;
  EXPECT_THAT(script_of(panel), HasSubstr("set lmargin 11\n"));
}

TEST(GnuplotQuoted, EscapesEveryCharacterThatEndsAString) {
  EXPECT_EQ(gnuplot_quoted("x1 [m]"), "'x1 [m]'");
  EXPECT_EQ(gnuplot_quoted("it's"), "'it''s'");
  EXPECT_EQ(gnuplot_quoted("a\nsystem 'x'\r\x7f"), "'asystem ''x'''");
}

TEST(Thinned, KeepsTheFirstAndStaysBelowTheLimit) {
  const Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(2501, 0.0, 50.0);
  EXPECT_LE(thinned(values, 800).size(), 800);
  EXPECT_EQ(thinned(values, 800)[0], 0.0);
  EXPECT_EQ(thinned(values, 2501), values);
  EXPECT_EQ(thinned(Eigen::VectorXd(), 10).size(), 0);
}

TEST(ShortPath, IsRelativeInTenthsOfAPixel) {
  EXPECT_EQ(short_path("M81.90,149.36 L941.79,149.36  "), "M81.9,149.4l859.9,0");
  EXPECT_EQ(short_path("M1.00,2.00 L1.50,1.70 L2.00,\n\tM7,8 L9,8"),
            "M1.00,2.00 L1.50,1.70 L2.00,\n\tM7,8 L9,8");  // a damaged path
  EXPECT_EQ(short_path("M1.00,2.00 L1.50,1.70\n\tL2.00,3.00 M7,8 L9,8 Z"), "M1,2l.5,-.3 .5,1.3M7,8l2,0Z");
}

TEST(ShortPath, RoundingErrorsDoNotAccumulate) {
  std::string path = "M0.00,0.00";
  for (int i = 1; i <= 1000; ++i) path += " L" + std::to_string(0.04 * i) + ",0.00";
  const std::string brief = short_path(path);
  double x = 0.0;
  for (std::size_t at = brief.find('l'); at != std::string::npos; at = brief.find(' ', at + 1))
    x += std::stod(brief.substr(at + 1));
  EXPECT_NEAR(x, 40.0, 0.05);
}

TEST(ShortPath, LeavesOtherPathsUnchanged) {
  for (const char* path : {"M-1,0 h2 M0,-1 v2", "", "M1", "m1,2 l3,4", "M1,2 Lx,3"}) EXPECT_EQ(short_path(path), path);
}

TEST(InlineSvg, DropsEmptyGroups) {
  const std::string svg = inline_svg(
      "<?xml?>\n<svg>\n<g fill=\"none\">\n</g>\n<g id=\"x\">\n\t<path d='M1.00,2.00 L3.00,2.00'/></g>\n"
      "<g a=\"b\"> </g>\n</svg>");
  EXPECT_EQ(svg, "<svg>\n<g id=\"x\">\n\t<path d='M1,2l2,0'/></g>\n</svg>");
  EXPECT_EQ(inline_svg("no picture"), "");
}

TEST(InlineSvg, IsAnImageWithALabelAndWithoutTitlesOfGnuplot) {
  const std::string svg = inline_svg(
      "<svg width=\"1\"><title>Gnuplot</title>\n<g id=\"gnuplot_plot_1a\"><title>gnuplot_plot_1a</title>\n<path/></g>"
      "<g id=\"gnuplot_plot_2a\"><title>truth</title><path/></g></svg>",
      "x1 [m] over \"time\"");
  EXPECT_EQ(svg,
            "<svg role=\"img\" aria-label=\"x1 [m] over &quot;time&quot;\" width=\"1\">\n<g>\n<path/></g>"
            "<g><title>truth</title><path/></g></svg>");
}

TEST(StandaloneSvg, HasAWhiteBackground) {
  const std::string drawn = "<svg>\n<rect x=\"0\" y=\"0\" fill=\"none\"/>\n<g fill=\"none\"></g></svg>";
  EXPECT_THAT(standalone_svg(drawn), HasSubstr("<rect x=\"0\" y=\"0\" fill=\"white\"/>"));
  EXPECT_THAT(standalone_svg(drawn), HasSubstr("<g fill=\"none\">"));
  EXPECT_THAT(drawn, Not(HasSubstr("white")));
}

}  // namespace
}  // namespace nlo::trainer

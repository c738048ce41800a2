// SPDX-License-Identifier: MIT
#include "trainer/report/gnuplot_script.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <tuple>

#include "trainer/report/gnuplot.h"
#include "trainer/report/html.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;

/// Contrast of two colours "#rrggbb" by WCAG 2: 1 to 21.
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

/// The colours of the style sheet by name: of light pages, and of dark ones.
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

/// The commands that draw one panel.
std::string script_of(Panel panel) {
  const auto directory = std::filesystem::temp_directory_path() / ("nlo-script-" + std::to_string(getpid()));
  std::filesystem::create_directory(directory);
  bool written = true;
  std::string script = figure_script({"", 400, 200, false, {std::move(panel)}}, 0, directory, written);
  std::filesystem::remove_all(directory);
  EXPECT_TRUE(written);
  return script;
}

TEST(Figure, HasTenColoursThatAreSeenOnLightAndDark) {
  constexpr double kVisible = 3.0;  // WCAG 2, of graphics
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

TEST(Figure, HasNumbersOnALogarithmicAxisWithoutAPowerOfTen) {
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

TEST(Figure, MakesRoomForLongNumbersLeftOfItsAxis) {
  Panel panel;
  panel.y_high = 1.0;
  EXPECT_THAT(script_of(panel), HasSubstr("set lmargin 9\n"));
  panel.y_low = 0.1219;
  panel.y_high = 0.1224;
  EXPECT_THAT(script_of(panel), HasSubstr("set lmargin 11\n"));
}

TEST(GnuplotQuoted, LeavesNoWayOut) {
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

}  // namespace
}  // namespace nlo::trainer

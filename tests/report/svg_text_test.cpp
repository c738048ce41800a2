// SPDX-License-Identifier: MIT
#include "trainer/report/svg_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(ShortPath, IsRelativeInTenthsOfAPixel) {
  EXPECT_EQ(short_path("M81.90,149.36 L941.79,149.36  "), "M81.9,149.4l859.9,0");
  EXPECT_EQ(short_path("M1.00,2.00 L1.50,1.70 L2.00,\n\tM7,8 L9,8"),
            "M1.00,2.00 L1.50,1.70 L2.00,\n\tM7,8 L9,8");  // damaged
  EXPECT_EQ(short_path("M1.00,2.00 L1.50,1.70\n\tL2.00,3.00 M7,8 L9,8 Z"), "M1,2l.5,-.3 .5,1.3M7,8l2,0Z");
}

TEST(ShortPath, RoundingDoesNotAddUp) {
  std::string path = "M0.00,0.00";
  for (int i = 1; i <= 1000; ++i) path += " L" + std::to_string(0.04 * i) + ",0.00";
  const std::string brief = short_path(path);
  double x = 0.0;
  for (std::size_t at = brief.find('l'); at != std::string::npos; at = brief.find(' ', at + 1))
    x += std::stod(brief.substr(at + 1));
  EXPECT_NEAR(x, 40.0, 0.05);
}

TEST(ShortPath, LeavesOtherPathsAlone) {
  for (const char* path : {"M-1,0 h2 M0,-1 v2", "", "M1", "m1,2 l3,4", "M1,2 Lx,3"}) EXPECT_EQ(short_path(path), path);
}

TEST(InlineSvg, DropsGroupsThatHoldNothing) {
  const std::string svg = inline_svg(
      "<?xml?>\n<svg>\n<g fill=\"none\">\n</g>\n<g id=\"x\">\n\t<path d='M1.00,2.00 L3.00,2.00'/></g>\n"
      "<g a=\"b\"> </g>\n</svg>");
  EXPECT_EQ(svg, "<svg>\n<g id=\"x\">\n\t<path d='M1,2l2,0'/></g>\n</svg>");
  EXPECT_EQ(inline_svg("no picture"), "");
}

TEST(InlineSvg, IsAnImageWithALabelInsteadOfGnuplotsNames) {
  const std::string svg = inline_svg(
      "<svg width=\"1\"><title>Gnuplot</title>\n<g id=\"gnuplot_plot_1a\"><title>gnuplot_plot_1a</title>\n<path/></g>"
      "<g id=\"gnuplot_plot_2a\"><title>truth</title><path/></g></svg>",
      "x1 [m] over \"time\"");
  EXPECT_EQ(svg,
            "<svg role=\"img\" aria-label=\"x1 [m] over &quot;time&quot;\" width=\"1\">\n<g>\n<path/></g>"
            "<g><title>truth</title><path/></g></svg>");
}

TEST(StandaloneSvg, StandsOnWhite) {
  const std::string drawn = "<svg>\n<rect x=\"0\" y=\"0\" fill=\"none\"/>\n<g fill=\"none\"></g></svg>";
  EXPECT_THAT(standalone_svg(drawn), HasSubstr("<rect x=\"0\" y=\"0\" fill=\"white\"/>"));
  EXPECT_THAT(standalone_svg(drawn), HasSubstr("<g fill=\"none\">"));
  EXPECT_THAT(drawn, Not(HasSubstr("white")));
}

}  // namespace
}  // namespace nlo::trainer

// SPDX-License-Identifier: MIT
// Checks that apply to every page, and whether this machine can draw plots.
#pragma once

#include <gtest/gtest.h>

#include <regex>
#include <string>
#include <vector>

#include "trainer/app/report/gnuplot.h"

namespace nlo::trainer {

inline long occurrences(const std::string& text, const std::string& what) {
  long count = 0;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

/// Expects that every element that must be closed is closed, in order.
inline void expect_balanced(const std::string& html) {
  std::vector<std::string> open;
  static const std::regex kTag(R"(<(/?)([a-zA-Z][a-zA-Z0-9]*)([^<>]*)>)");
  for (std::sregex_iterator tag(html.begin(), html.end(), kTag), end; tag != end; ++tag) {
    const std::string name = (*tag)[2], rest = (*tag)[3];
    if (name == "meta" || (!rest.empty() && rest.back() == '/')) continue;
    if ((*tag)[1].length() == 0) {
      open.push_back(name);
    } else {
      ASSERT_FALSE(open.empty()) << "</" << name << "> closes no element";
      ASSERT_EQ(open.back(), name);
      open.pop_back();
    }
  }
  EXPECT_TRUE(open.empty()) << "<" << open.back() << "> is never closed";
}

/// Returns the number of pictures without role or label, table headings without a scope, and titles that gnuplot wrote.
inline long nameless(const std::string& page) {
  long count = occurrences(page, "gnuplot_plot");
  static const std::regex kPicture(
      R"re(<svg(?! role="img" aria-label="[^"]+")|<th(?=[ >])(?! scope="(col|row|rowgroup)"))re");
  for (std::sregex_iterator found(page.begin(), page.end(), kPicture), end; found != end; ++found) ++count;
  return count;
}

inline bool gnuplot_is_here() {
  return draw({Figure{"", 200, 100, false, {Panel{}}}}).failure.find("could not be started") == std::string::npos;
}

}  // namespace nlo::trainer

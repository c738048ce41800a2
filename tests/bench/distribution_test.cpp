// SPDX-License-Identifier: MIT
#include "bench/distribution.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace nlo::bench {
namespace {

namespace fs = std::filesystem;

Distribution one_to_thousand() {
  Distribution durations("one to thousand", 1000);
  for (int i = 0; i < 1000; ++i) durations.add(1 + i * 7 % 1000);  // each value once, shuffled
  durations.sort();
  return durations;
}

TEST(Distribution, QuantilesAreThoseOfAllValues) {
  const Distribution durations = one_to_thousand();
  EXPECT_EQ(durations.quantile_ns(0.0), 1.0);
  EXPECT_EQ(durations.quantile_ns(0.5), 500.0);
  EXPECT_EQ(durations.quantile_ns(0.99), 990.0);
  EXPECT_EQ(durations.quantile_ns(1.0), 1000.0);
}

TEST(Distribution, DropsValuesBeyondItsCapacityAndFreesUnusedMemory) {
  Distribution small("small", 2), empty("empty", 5);
  for (const int value : {5, 3, 9}) small.add(value);
  small.sort();
  EXPECT_THAT(small.values_ns(), ::testing::ElementsAre(3, 5));
  empty.sort();
  EXPECT_EQ(empty.quantile_ns(0.5), 0.0);
  EXPECT_TRUE(empty.values_ns().empty());
}

TEST(DrawHistograms, WritesAFigureOrSaysWhyItCannot) {
  const Distribution durations = one_to_thousand();
  // A quote in a path must not end the string of gnuplot.
  const fs::path path = fs::path(::testing::TempDir()) / ("nlo'histogram" + std::to_string(getpid()) + ".svg");
  ASSERT_EQ(draw_histograms({{"calls", {&durations}}, {"again", {&durations, &durations}}}, path.string()), "");
  std::ifstream file(path);
  const std::string svg((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  EXPECT_THAT(svg, ::testing::AllOf(::testing::HasSubstr("</svg>"),
                                    ::testing::HasSubstr("one to thousand: median 500 ns, 99.9 % 999 ns")));
  fs::remove(path);
  EXPECT_THAT(draw_histograms({{"calls", {&durations}}}, "/no/such/folder/picture.svg"),
              ::testing::HasSubstr("/no/such/folder/picture.svg"));
}

TEST(DrawHistograms, SaysThatGnuplotIsMissing) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/no/such/folder", 1);
  const Distribution durations = one_to_thousand();
  EXPECT_THAT(draw_histograms({{"calls", {&durations}}}, ::testing::TempDir() + "/picture.svg"),
              ::testing::HasSubstr("gnuplot is missing"));
  setenv("PATH", path.c_str(), 1);
}

}  // namespace
}  // namespace nlo::bench

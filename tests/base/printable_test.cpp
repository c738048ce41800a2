// SPDX-License-Identifier: MIT
#include "trainer/base/printable.h"

#include <gtest/gtest.h>

#include "trainer/base/nearest_name.h"

namespace nlo::trainer {
namespace {

TEST(Printable, LeavesTextOfEveryLanguageAsItIs) {
  const std::string text = "\tθ̇ in rad·s⁻¹, 角度 🚗, \xc2\xa0\n";
  EXPECT_EQ(printable(text), text);
}

TEST(Printable, ShowsEveryControlCharacterInsteadOfSendingIt) {
  EXPECT_EQ(printable("a\x1b[31mb\rc\x7f"), "a\\x1b[31mb\\x0dc\\x7f");
  EXPECT_EQ(printable(std::string("\0", 1)), "\\x00");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "\\xc2\\x9b31m")
      << "U+009B begins an escape sequence, like ESC [";
  EXPECT_EQ(printable("\x9b"
                      "31m"),
            "\\x9b31m")
      << "and so does its single byte in Latin 1";
}

TEST(Printable, NoPairOfBytesPrintsAControlCharacterOrAWrongLength) {
  for (int first = 0; first < 256; ++first)
    for (int second = 0; second < 256; ++second) {
      const std::string text = {static_cast<char>(first), static_cast<char>(second)};
      const std::string shown = printable(text);
      for (std::size_t i = 0; i < shown.size(); ++i) {
        const auto byte = static_cast<unsigned char>(shown[i]);
        ASSERT_TRUE((byte >= 0x20 && byte != 0x7f) || byte == '\n' || byte == '\t') << first << " " << second;
        if (byte >= 0x80 && byte < 0xa0) {
          ASSERT_GT(i, 0U);
          ASSERT_GT(static_cast<unsigned char>(shown[i - 1]), 0xc2) << first << " " << second;
        }
      }
    }
}

TEST(Printable, ShowsATruncatedSequenceByteByByte) {
  EXPECT_EQ(printable("\xe8\xa7"), "\\xe8\\xa7");
  EXPECT_EQ(printable("\xe8(x"), "\\xe8(x");
}

TEST(NearestName, CountsEdits) {
  EXPECT_EQ(edit_distance("", ""), 0u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
  EXPECT_EQ(edit_distance("sitting", "kitten"), 3u);
}

TEST(NearestName, FindsATypo) {
  EXPECT_EQ(nearest_name("eigen_values", {"pairs", "eigenvalues", "hold"}), "eigenvalues");
}

TEST(NearestName, ReturnsTheFirstOfEquallyNearNames) {
  EXPECT_EQ(nearest_name("ab1", {"ab2", "ab3"}), "ab2");
}

TEST(NearestName, ReturnsNothingIfEveryNameIsFar) {
  EXPECT_EQ(nearest_name("voltage", {"theta", "time"}), "");
  EXPECT_EQ(nearest_name("x", {}), "");
}

}  // namespace
}  // namespace nlo::trainer

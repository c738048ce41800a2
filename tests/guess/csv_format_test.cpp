// SPDX-License-Identifier: MIT
#include "trainer/guess/csv_format.h"

#include <gtest/gtest.h>

namespace nlo::trainer {
namespace {

void expect(const char* text, char separator, char decimal) {
  const CsvFormat format = guess_csv_format(text);
  EXPECT_EQ(format.separator, separator) << text;
  EXPECT_EQ(format.decimal, decimal) << text;
}

TEST(CsvFormatGuess, SeesSeparatorAndDecimal) {
  expect("t,x\n0,1.5\n1,2.5\n", ',', '.');
  expect("t;x\n0;1.5\n1;2.5\n", ';', '.');
  expect("t;x\n0,0;1,5\n0,1;2,5\n", ';', ',');
  expect("t;x\n0;1\n1;2\n", ';', '.');
  expect("t\tx\n0\t1,5\n1\t-2,5e-3\n", '\t', ',');
  expect("t x y\n0 1.5 2\n1   2.5 3\n", ' ', '.');
  expect("# recorded: a; b, c\nt;x\n0;1,5\n", ';', ',');
}

TEST(CsvFormatGuess, LeavesToTheReaderWhatIsNoTable) {
  expect("", ',', '.');
  expect("x\n1\n2\n", ',', '.');
  expect("\"a;b\",c\n1,2\n", ',', '.');           // quotes hold a separator
  expect("gyro x,gyro y\n1,2\n3,4\n", ',', '.');  // blanks in headings separate nothing
  expect("t;x\n0;1,5\n1;2.5\n", ';', '.');        // both: whatever it is, it is said by the reader
}

}  // namespace
}  // namespace nlo::trainer

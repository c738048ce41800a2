// SPDX-License-Identifier: MIT
#include "trainer/data/csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>

#include "tests/data/data_testing.h"
#include "trainer/data/csv_format.h"

namespace nlo::trainer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

CsvTable parse(const std::string& text, const CsvFormat& format = {}) {
  return CsvTable::parse(text, "a.csv", format);
}
std::string error_in(const std::string& text, const CsvFormat& format = {}) {
  return thrown_message([&] { parse(text, format); });
}
std::string error_in_column(const std::string& text, const std::string& heading, const CsvFormat& format = {}) {
  return thrown_message([&] { parse(text, format).column(heading); });
}

TEST(Csv, FindsColumnsByNameInAnyOrder) {
  const CsvTable table = parse("b,a\n1,2\n3,4\n");
  EXPECT_EQ(table.rows(), 2);
  EXPECT_EQ(table.column("a"), Eigen::Vector2d(2, 4));
  EXPECT_EQ(table.column("b"), Eigen::Vector2d(1, 3));
}

TEST(Csv, ReadsNumbersAsTheyAreWritten) {
  const CsvTable table = parse("x\n1.5\n-2e-3\n+4\n  7 \n\"8.25\"\n.5\n-0.0\n4.9e-324\n1.7976931348623157e308\n");
  Eigen::VectorXd expected(9);
  expected << 1.5, -2e-3, 4, 7, 8.25, 0.5, -0.0, 4.9e-324, 1.7976931348623157e308;
  EXPECT_EQ(table.column("x"), expected);
}

TEST(Csv, AcceptsCrLfAByteOrderMarkAndBlankLinesAtTheEnd) {
  for (const char* text : {"a,b\n1,2", "a,b\n1,2\n", "a,b\r\n1,2\r\n",
                           "\xEF\xBB\xBF"
                           "a,b\r\n1,2\r\n\r\n\n",
                           "a , b\n1,2\n  \n\n"}) {
    const CsvTable table = parse(text);
    EXPECT_EQ(table.rows(), 1) << text;
    EXPECT_EQ(table.column("a")[0], 1.0) << text;
    EXPECT_EQ(table.column("b")[0], 2.0) << text;
  }
}

TEST(Csv, KeepsCommasAndLineBreaksInsideQuotes) {
  const CsvTable table = parse("\"a, in m\",note,c\n1,\"said \"\"no\"\",\ntwice\",3\n4,,6\n");
  EXPECT_EQ(table.column("a, in m"), Eigen::Vector2d(1, 4));
  EXPECT_EQ(table.column("c"), Eigen::Vector2d(3, 6));
  EXPECT_EQ(table.line(1), 4);  // the quoted cell spans lines 2 and 3
}

TEST(Csv, IgnoresCellsOfUnusedColumns) {
  EXPECT_EQ(parse("t,comment\n1,nan\n2,\n").column("t"), Eigen::Vector2d(1, 2));
}

TEST(Csv, RefusesAnEmptyFile) {
  EXPECT_THAT(error_in(""), HasSubstr("a.csv: the file is empty"));
  EXPECT_THAT(error_in("\n  \r\n"), HasSubstr("a.csv: the file is empty"));
  EXPECT_THAT(error_in("a,b\n\n"), HasSubstr("a.csv: there is a header but no data"));
}

TEST(Csv, NamesTheLineOfARaggedRow) {
  EXPECT_THAT(error_in("a,b\n1,2\n3\n5,6\n"), HasSubstr("a.csv:3: expected 2 cells as in the header, found 1"));
  EXPECT_THAT(error_in("a,b\n1,2,3\n5,6\n"), HasSubstr("a.csv:2: expected 2 cells as in the header, found 3"));
  EXPECT_THAT(error_in("a,b\n1,2\n\n5,6\n"), AllOf(HasSubstr("a.csv:3: "), HasSubstr("the line is blank")));
  EXPECT_THAT(error_in("a\n1\n\n5\n"), HasSubstr("a.csv:3: "));
  EXPECT_THAT(error_in("a,b\n1,2\n3"), HasSubstr("the log ends inside a row: delete this last row"));
}

TEST(Csv, NamesTheCellThatIsNotAFiniteNumber) {
  EXPECT_THAT(error_in_column("t,y\n1,2\n2,nan\n", "y"), HasSubstr("a.csv:3:y: \"nan\" is not finite"));
  EXPECT_THAT(error_in_column("t,y\n1,-inf\n", "y"), HasSubstr("a.csv:2:y: \"-inf\" is not finite"));
  EXPECT_THAT(error_in_column("t,y\n1, \n", "y"), HasSubstr("a.csv:2:y: \"\" is empty"));
  EXPECT_THAT(error_in_column("t,y\n1,2.5V\n", "y"), HasSubstr("a.csv:2:y: \"2.5V\" is not a number"));
  EXPECT_THAT(error_in_column("t,y\n1,\"2,5\"\n", "y"), HasSubstr("a.csv:2:y: \"2,5\" is not a number"));
  EXPECT_THAT(error_in_column("t,y\n1,+-2\n", "y"), HasSubstr("is not a number"));
  EXPECT_THAT(error_in_column("t,y\n1,0x10\n", "y"), HasSubstr("is not a number"));
  EXPECT_THAT(error_in_column("t,y\n1,1e999\n", "y"), HasSubstr("a.csv:2:y: \"1e999\" is beyond the range of double"));
}

TEST(Csv, ShowsOnlyThePrintableStartOfABadCell) {
  std::string text = "y\n\x1b[31m";
  text.append(1000, 'x');
  const std::string message = error_in_column(text, "y");
  EXPECT_EQ(message.find('\x1b'), std::string::npos);
  EXPECT_LT(message.size(), 200u);
}

TEST(Csv, NamesTheExistingColumnsAndTheNearestName) {
  EXPECT_THAT(
      error_in_column("time,theta,alpha\n1,2,3\n", "tetha"),
      AllOf(HasSubstr("a.csv:1: no column \"tetha\" among time, theta, alpha"), HasSubstr("did you mean \"theta\"?")));
}

TEST(Csv, RefusesADuplicateHeadingOnlyIfItIsUsed) {
  EXPECT_THAT(error_in_column("a,b,a\n1,2,3\n", "a"), HasSubstr("a.csv:1: the heading \"a\" occurs twice"));
  EXPECT_EQ(parse("a,b,a\n1,2,3\n").column("b")[0], 2.0);
}

TEST(Csv, FindsTheHeadingsBelowAPreamble) {
  for (const char* preamble :
       {"\n\n", "Logger 2.1\nSerial 0042\nDate 2026-11-20 10:11:12\n\n", "Serial,0042\nRate,100\n\n", "# Logger\n\n",
        "Logger 2.1\n# comment\n", "a,b,c,d\n1,2,3,4\n"}) {
    const CsvTable table = parse(std::string(preamble) + "t,x\n0,5\n1,6\n2,7\n3,8\n");
    EXPECT_EQ(table.rows(), 4) << preamble;
    EXPECT_EQ(table.column("x")[0], 5.0) << preamble;
    EXPECT_EQ(table.line(0), std::count(preamble, preamble + std::string_view(preamble).size(), '\n') + 2) << preamble;
  }
  EXPECT_EQ(parse("t,x\n\n\n0,5\n1,6\n").rows(), 2);
  EXPECT_THAT(error_in("Logger 2.1\n\n0,5\n1,6\n2,7\n"), HasSubstr("a.csv:3: the line has numbers, but the headings"));
}

TEST(Csv, SkipsHeadingsThatARestartedLoggerWritesAgain) {
  const CsvTable table = parse("t,x\n0,5\n1,6\nt,x\n0,7\n");
  EXPECT_EQ(table.column("x"), Eigen::Vector3d(5, 6, 7));
  EXPECT_EQ(table.line(2), 5);
  EXPECT_THAT(error_in_column("t,x\n0,5\n1,6\nt,y\n0,7\n", "x"), HasSubstr("a.csv:4:x: \"y\" is not a number"));
}

TEST(Csv, ReadsARowOfUnitsBelowTheHeadings) {
  for (const char* units : {"s,rad,rad/s", "[s],[rad],(rad/s)", "s,rad,rad/s\n"}) {
    const CsvTable table = parse(std::string("t,x,v\n") + units + "\n0,1,2\n1,2,3\n");
    EXPECT_EQ(table.rows(), 2) << units;
    EXPECT_EQ(table.unit("t"), "s");
    EXPECT_EQ(table.unit("v"), "rad/s");
  }
  EXPECT_EQ(parse("Logger\nt,x\ns,-\n0,1\n1,2\n").unit("x"), "");
  EXPECT_EQ(parse("t,x\n0,1\n1,2\n").unit("x"), "");
  // A row of words among the first rows is an error, not a header.
  EXPECT_THAT(error_in_column("t,x\n0,5\nERR,ERR\n1,6\n2,7\n3,8\n", "x"), HasSubstr("a.csv:3:x: \"ERR\" is not"));
  EXPECT_THAT(error_in_column("t,x\nnow,far\n0,1\n1,2\n", "x"), HasSubstr("no column \"x\" among now, far"));
}

TEST(Csv, ReadsLinesThatEndInACarriageReturn) {
  const CsvTable table = parse("t,x\r0,5\r1,6\r");
  EXPECT_EQ(table.column("x"), Eigen::Vector2d(5, 6));
  EXPECT_EQ(table.line(1), 3);
}

TEST(Csv, TreatsTheWordsOfLoggersAsMissingValues) {
  for (const char* word : {"", "-", "--", "null", "NULL", "None", "NA", "N/A", "#N/A", "nan", "-nan(ind)", "1.#QNAN",
                           "-1.#IND", "1.#IND", "\"\""}) {
    std::vector<Eigen::Index> missing;
    EXPECT_EQ(parse(std::string("t,x\n0,5\n1,") + word + "\n").column("x", missing)[0], 5.0) << word;
    EXPECT_EQ(missing, std::vector<Eigen::Index>{1}) << word;
  }
  std::vector<Eigen::Index> missing;
  for (const char* none : {"nothing", "-x", "nano", "high", "inf", "1.#INF"})
    EXPECT_NE(thrown_message([&] { parse(std::string("t,x\n0,5\n1,") + none + "\n").column("x", missing); }),
              "no error")
        << none;
}

TEST(Csv, NamesACompressedFile) {
  EXPECT_THAT(error_in("\x1f\x8b\x08..."), HasSubstr("a.csv: is compressed by gzip: gunzip"));
  EXPECT_THAT(error_in("PK\x03\x04..."), HasSubstr("a zip archive or a spreadsheet"));
}

TEST(CsvFormat, IsTakenFromTheFileIfTheConfiguredOneGivesAShorterTable) {
  const auto format = [](const char* text, CsvFormat configured) { return format_in(text, configured); };
  const CsvFormat comma, semicolon{.separator = ';', .decimal = ','};
  EXPECT_EQ(format("t;x\n0,0;1,5\n0,1;2,5\n", comma).separator, ';');
  EXPECT_EQ(format("t;x\n0,0;1,5\n0,1;2,5\n", comma).decimal, ',');
  EXPECT_EQ(format("t,x\n0.0,1.5\n0.1,2.5\n", semicolon).separator, ',');
  EXPECT_EQ(format("t,x\n0.0,1.5\n0.1,2.5\n", semicolon).decimal, '.');
  EXPECT_EQ(format("t;x\n0.0;1.5\n", semicolon).decimal, '.');
  EXPECT_EQ(format("t;x\n0;1\n", semicolon).decimal, ',');  // as configured if the file does not show it
  EXPECT_EQ(format("t,note\n0,a b\n1,c d\n", comma).separator, ',');
  EXPECT_EQ(format("x\n1\n2\n", semicolon).separator, ';');
}

TEST(Csv, NamesTheSeparatorThatAFileSeemsToHave) {
  EXPECT_THAT(error_in("a;b\n1;2\n"),
              HasSubstr("a.csv:1: the columns seem to be separated by semicolons: set separator = "
                        "\";\" in [log], or write the log with commas"));
  EXPECT_THAT(error_in("a\tb\n1\t2\n"), HasSubstr("tabs: set separator = \"tab\""));
  EXPECT_THAT(error_in("a,b\n1,2\n", {.separator = ';'}), HasSubstr("commas: set separator = \",\""));
  EXPECT_THAT(error_in_column("a b\n1 2\n", "a"),
              HasSubstr("if spaces separate the columns, set separator = \"space\""));
}

TEST(Csv, UsesTheConfiguredSeparatorAndDecimalMark) {
  struct Case {
    const char* text;
    CsvFormat format;
  };
  for (const Case& c :
       std::vector<Case>{{"a;b\n1.5;-2e3\n2;4\n", {.separator = ';'}},
                         {"a;b\r\n1,5;-2e3\r\n2;4,0\r\n", {.separator = ';', .decimal = ','}},
                         {"a\tb\n1.5\t-2e3\n 2\t4\n", {.separator = '\t'}},
                         {"a b\n1.5 -2e3\n2 4\n", {.separator = ' '}},
                         {"  a   b  \r\n1.5\t -2e3 \r\n   2   4", {.separator = ' '}},
                         {"\"a\" \"b\"\n1,5 -2000\n2 \"4\"  \n\n", {.separator = ' ', .decimal = ','}}}) {
    const CsvTable table = parse(c.text, c.format);
    EXPECT_EQ(table.rows(), 2) << c.text;
    EXPECT_EQ(table.column("a"), Eigen::Vector2d(1.5, 2)) << c.text;
    EXPECT_EQ(table.column("b"), Eigen::Vector2d(-2000, 4)) << c.text;
  }
  EXPECT_EQ(parse("a\tb\tc\n\t2\t\n", {.separator = '\t'}).column("b")[0], 2.0);  // tabs keep empty cells
}

TEST(Csv, NamesWrongDecimalMarks) {
  EXPECT_THAT(error_in_column("a;b\n1,5;2\n", "a", {.separator = ';'}),
              AllOf(HasSubstr("a.csv:2:a: \"1,5\" is not a number"), HasSubstr("set decimal = \",\" in [log]")));
  EXPECT_THAT(error_in_column("a;b\n1.234,5;2\n", "a", {.separator = ';', .decimal = ','}),
              HasSubstr("\"1.234,5\" has a point, but [log] decimal = \",\" declares"));
  EXPECT_THAT(error_in_column("a;b\n1,2,3;2\n", "a", {.separator = ';', .decimal = ','}), HasSubstr("is not a number"));
}

TEST(Csv, SkipsCommentLinesButCountsThem) {
  const CsvTable table = parse("# rig 3\n  # 2026-01-05, \"open\r\na,b\n1,2\n# paused\n#\n3,4\n# end");
  EXPECT_EQ(table.column("b"), Eigen::Vector2d(2, 4));
  EXPECT_EQ(table.line(0), 4);
  EXPECT_EQ(table.line(1), 7);
  EXPECT_THAT(error_in_column("#\n#\na,b\n1,2\n", "c"), HasSubstr("a.csv:3: no column \"c\""));
  EXPECT_EQ(parse("a,b\n1,\"#2\"\n").column("a")[0], 1.0);  // control: within a row # is an ordinary character
  EXPECT_THAT(error_in_column("a,b\n1,#2\n", "b"), HasSubstr("\"#2\" is not a number"));
}

TEST(Csv, ReportsAMissingOrCommentedHeader) {
  EXPECT_THAT(error_in("# time, y\n0,1\n1,2\n"), HasSubstr("a.csv:2: the line has numbers, but the headings of the "
                                                           "columns are expected here: is \"# time, y\" above them "
                                                           "the header row? delete its #"));
  EXPECT_THAT(error_in("0,1\n1,2\n"),
              HasSubstr("a.csv:1: the line has numbers, but the headings of the columns are expected here: "
                        "write a header row above them"));
}

TEST(Csv, NamesUtf16AndTheCommandThatConvertsIt) {
  for (const std::string& text : {std::string("\xFF\xFEt\0,\0", 6), std::string("\xFE\xFF\0t\0,", 6)})
    EXPECT_EQ(
        error_in(text),
        "a.csv: the file is UTF-16 (by its byte order mark), but UTF-8 is expected: convert it with iconv -f UTF-16 "
        "-t UTF-8 a.csv > utf8.csv");
}

TEST(Csv, AcceptsMissingCellsWhereTheyAreAllowed) {
  const CsvTable table = parse("t,y\n1,2\n2,\n3,NaN\n4,-nan\n5,NA\n6,\"\"\n7,nan(ind)\n8,5\n");
  std::vector<Eigen::Index> missing;
  const Eigen::VectorXd y = table.column("y", missing);
  EXPECT_EQ(missing, (std::vector<Eigen::Index>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(y[0], 2.0);
  EXPECT_EQ(y[7], 5.0);
  for (const Eigen::Index row : missing) EXPECT_TRUE(std::isnan(y[row])) << row;
  EXPECT_THAT(thrown_message([&] { table.column("y"); }),
              HasSubstr("a.csv:3:y: \"\" is empty"));  // control: in no other column
  missing.clear();
  EXPECT_EQ(table.column("t", missing), table.column("t"));
  EXPECT_TRUE(missing.empty());
  for (const char* cell : {"inf", "-inf", "nano", "1e999", "-x"}) {
    EXPECT_THAT(thrown_message([&] { parse(std::string("t,y\n1,") + cell + "\n").column("y", missing); }),
                HasSubstr("a.csv:2:y: "))
        << cell;
  }
}

TEST(Csv, RefusesQuotesThatDoNotClose) {
  EXPECT_THAT(error_in("a,b\n1,2\n3,\"4\n5,6\n"), HasSubstr("a.csv:3: a quote is opened and never closed"));
  EXPECT_THAT(error_in("a,b\n1,\"2\"x\n"), HasSubstr("a.csv:2: text follows a closing quote"));
}

TEST(Csv, IsStillValidIfATableOfShortTextIsMoved) {
  CsvTable table = parse("a\n1\n");
  const CsvTable moved = std::move(table);
  EXPECT_EQ(moved.column("a")[0], 1.0);
}

TEST(Csv, NamesAMissingFile) {
  EXPECT_THAT(thrown_message([] { CsvTable::read("/no/such/log.csv"); }), HasSubstr("/no/such/log.csv"));
}

TEST(Csv, GivesNumbersOrAnErrorForAnyBytes) {
  constexpr unsigned kSeed = 11;
  std::mt19937 engine(kSeed);
  const std::string good = "t,\"y, in m\",z\r\n0,1.5,-2\n1,\"2.5\",3e-4\n2,3.5,4\n";
  const std::string bytes("\",\n\r;\0 \xEF.e+-0n#", 16);
  int read = 0;
  for (int round = 0; round < 10000; ++round) {
    const CsvFormat format = round % 2 == 0 ? CsvFormat{} : CsvFormat{.separator = ' '};
    std::string text = good;
    if (round % 2 == 1) std::replace(text.begin(), text.end(), ',', ' ');
    for (auto edits = 1 + engine() % 3; edits > 0; --edits) {
      const std::size_t at = engine() % text.size();
      const char byte = bytes[engine() % bytes.size()];
      engine() % 2 == 0 ? void(text[at] = byte) : void(text.insert(at, 1, byte));
    }
    const std::string error = thrown_message([&] {
      const CsvTable table = parse(text, format);
      for (const std::string& heading : table.headings()) ASSERT_TRUE(table.column(heading).allFinite()) << text;
      ++read;
    });
    ASSERT_TRUE(error == "no error" || error.starts_with("a.csv:")) << "seed " << kSeed << ": " << error;
  }
  EXPECT_GT(read, 200);  // control: not everything is refused
}

TEST(Csv, ReadsFiveThousandRowsInMilliseconds) {
  std::string text = "c0,c1,c2,c3,c4,c5,c6,c7,c8,c9,c10,c11,c12,c13,c14\n";
  for (int row = 0; row < 5000; ++row) {
    for (int i = 0; i < 15; ++i) text += std::to_string(0.001 * (row + i)) + (i < 14 ? "," : "\n");
  }
  const auto start = std::chrono::steady_clock::now();
  const CsvTable table = parse(text);
  double sum = 0.0;
  for (std::size_t i = 0; i < 15; ++i) sum += table.column(table.headings()[i]).sum();
  const double elapsed_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  RecordProperty("elapsed_ms", std::to_string(elapsed_ms));
  EXPECT_GT(sum, 0.0);
  // Measured: 4 ms. The limit allows for a debug build with sanitizers on a busy machine; the test finds quadratic run
  // time.
  EXPECT_LT(elapsed_ms, 1000.0);
}

}  // namespace
}  // namespace nlo::trainer

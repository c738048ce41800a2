// SPDX-License-Identifier: MIT
// Strict reader of logs in columns: one header row, then rows of as many cells (RFC 4180 quoting; LF, CRLF or CR). Let
// pass are a byte order mark, lines that begin with #, lines above the headings, a row of units and blank lines below
// them, and blank lines at the end. Whatever is doubtful is an error that names file and line.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace nlo::trainer {

/// How a file writes its rows.
struct CsvFormat {
  char separator = ',';  ///< ' ': any number of spaces and tabs
  char decimal = '.';    ///< or ','
};

/// Reads a cell as a finite decimal number into `value`. Returns the reason if it is none, or nothing.
std::optional<const char*> read_number(std::string_view cell, char decimal, double& value);

class CsvTable {
 public:
  /// Splits `text` into cells. `file` is the name that errors show. Throws codegen::Error on an empty file, UTF-16, a
  /// MAT-file, a bag of ROS, a compressed file, a file without data rows, a ragged row, an unclosed quote, or a row of
  /// numbers where the header is expected.
  static CsvTable parse(std::string text, std::string file, const CsvFormat& format = {});
  /// Reads a file by its own format where it is not `format` (format_in).
  static CsvTable read(const std::string& path, const CsvFormat& format = {});

  const std::string& file() const { return file_; }
  const std::vector<std::string>& headings() const { return headings_; }
  /// The unit below a heading; empty: the file has no row of units, or none there.
  std::string unit(std::string_view heading) const;
  const CsvFormat& format() const { return format_; }
  /// Whether several columns have this heading: none of them can be asked for.
  bool is_ambiguous(std::string_view heading) const;
  Eigen::Index rows() const { return static_cast<Eigen::Index>(lines_.size()); }

  /// Line of the file (from 1) on which data row `row` (from 0) starts.
  int line(Eigen::Index row) const { return lines_[static_cast<std::size_t>(row)]; }

  /// The cells under `heading` as numbers. Throws codegen::Error when there is no such heading (names those there are),
  /// when it occurs twice, or when a cell is empty, not a decimal number, or not finite (names the cell).
  Eigen::VectorXd column(std::string_view heading) const;

  /// Reads a column that may have missing values. Cells that are empty, -, NaN, NA, null or None become NaN, and their
  /// rows, increasing, are added to `missing`. So are cells that equal one of `words`, also as a number.
  Eigen::VectorXd column(std::string_view heading, std::vector<Eigen::Index>& missing,
                         const std::vector<std::string>& words = {}) const;

  /// Returns the cells of a column as they are in the file.
  std::vector<std::string_view> cells(std::string_view heading) const;

  /// Returns one of them.
  std::string_view cell(std::string_view heading, Eigen::Index row) const;

  /// Whether two rows are copies of each other.
  bool same_cells(Eigen::Index a, Eigen::Index b) const;

 private:
  CsvTable() = default;

  /// Where a cell stands in the text: half as large as a view, of which a log has millions.
  struct Place {
    std::uint64_t begin : 40, size : 24;
  };

  Place place_in_text(std::string_view cell, int line) const;
  std::string_view text_at(Place place) const { return std::string_view(*text_).substr(place.begin, place.size); }

  Eigen::Index place_of(std::string_view heading) const;

  Eigen::VectorXd read_column(std::string_view heading, std::vector<Eigen::Index>* missing,
                              const std::vector<std::string>& words) const;

  std::string file_;
  CsvFormat format_;
  std::shared_ptr<const std::string> text_;  ///< text that the cells point into
  std::vector<std::string> headings_;
  std::vector<std::string> units_;  ///< as many; empty: no row of units
  int header_line_ = 1;
  std::vector<Place> cells_;  ///< rows x headings, row by row, unquoted
  std::vector<int> lines_;
};

}  // namespace nlo::trainer

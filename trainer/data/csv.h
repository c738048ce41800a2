// SPDX-License-Identifier: MIT
// Strict reader of logs in columns: one header row, then rows with as many cells (RFC 4180 quoting; LF, CRLF or CR). It
// accepts a byte order mark, lines that begin with #, lines above the headings, a row of units and blank lines below
// the headings, and blank lines at the end. Anything else that is ambiguous is an error with file and line.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace nlo::trainer {

/// The format of a file's rows.
struct CsvFormat {
  char separator = ',';  ///< ' ': any number of spaces and tabs
  char decimal = '.';    ///< or ','
};

/// Reads a cell as a finite decimal number into `value`. Returns the reason if it is not one, otherwise nothing.
std::optional<const char*> read_number(std::string_view cell, char decimal, double& value);

class CsvTable {
 public:
  /// Splits `text` into cells. `file` is the name that errors show. Throws codegen::Error on an empty file, UTF-16, a
  /// MAT-file, a bag of ROS, a compressed file, a file without data rows, a ragged row, an unclosed quote, or a row of
  /// numbers where the header is expected.
  static CsvTable parse(std::string text, std::string file, const CsvFormat& format = {});
  /// Reads a file, in `format` unless its lines show another format (format_in).
  static CsvTable read(const std::string& path, const CsvFormat& format = {});

  const std::string& file() const { return file_; }
  const std::vector<std::string>& headings() const { return headings_; }
  /// Returns the unit below a heading; empty if the file has no row of units or no unit there.
  std::string unit(std::string_view heading) const;
  const CsvFormat& format() const { return format_; }
  /// Returns true if several columns have this heading. Such columns cannot be read.
  bool is_ambiguous(std::string_view heading) const;
  Eigen::Index rows() const { return static_cast<Eigen::Index>(lines_.size()); }

  /// Returns the line of the file (from 1) on which data row `row` (from 0) starts.
  int line(Eigen::Index row) const { return lines_[static_cast<std::size_t>(row)]; }

  /// Returns the cells under `heading` as numbers. Throws codegen::Error if there is no such heading (lists the
  /// headings), if it occurs twice, or if a cell is empty, not a decimal number, or not finite (names the cell).
  Eigen::VectorXd column(std::string_view heading) const;

  /// Reads a column that may have missing values. Cells that are empty, -, NaN, NA, null or None become NaN, and their
  /// rows, increasing, are added to `missing`. Cells that equal one of `words`, as text or as a number, are treated in
  /// the same way.
  Eigen::VectorXd column(std::string_view heading, std::vector<Eigen::Index>& missing,
                         const std::vector<std::string>& words = {}) const;

  /// Returns the cells of a column as they are in the file.
  std::vector<std::string_view> cells(std::string_view heading) const;

  /// Returns one cell as it is in the file.
  std::string_view cell(std::string_view heading, Eigen::Index row) const;

  /// Returns true if two rows have the same cells.
  bool same_cells(Eigen::Index a, Eigen::Index b) const;

 private:
  CsvTable() = default;

  /// The position of a cell in the text. It is half as large as a view; a log has millions of cells.
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
  std::vector<std::string> units_;  ///< one for each heading; empty: no row of units
  int header_line_ = 1;
  std::vector<Place> cells_;  ///< rows x headings, row by row, unquoted
  std::vector<int> lines_;
};

}  // namespace nlo::trainer

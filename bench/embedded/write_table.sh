# SPDX-License-Identifier: MIT
# shellcheck shell=sh
# Source this file in scripts that write a table into a page.

# write_table BEGIN END TABLE FILE replaces the lines between the lines BEGIN and END of FILE by TABLE.
write_table() {
  awk -v begin="$1" -v end="$2" -v table="$3" '
    $0 == begin { print; print ""; print table; print ""; skip = found = 1 }
    $0 == end { skip = 0 }
    !skip { print }
    END { exit !found || skip }' "$4" >"$4.new" || { rm -f "$4.new"; echo "$4: has no $1 ... $2" >&2; return 1; }
  mv "$4.new" "$4"
}

# compare_table BEGIN END TABLE FILE checks recorded figures: each row of TABLE must be between the lines BEGIN and END
# of FILE, and each number must be within 5 % of the recorded one, on both sides. Rows are matched by their cells
# without numbers. Prints the differences and fails if there are any.
compare_table() {
  awk -v begin="$1" -v end="$2" -v table="$3" -v file="$4" '
    function number(cell) { return cell ~ /^-?[0-9]+(\.[0-9]+)?$/ }
    function key(cells, count,  i, text) {
      for (i = 2; i < count; ++i) if (!number(cells[i])) text = text "| " cells[i] " "
      return text
    }
    BEGIN {
      while ((getline line < file) > 0) {
        if (line == begin) inside = 1
        if (line == end) inside = 0
        if (!inside || line !~ /^\|/) continue
        count = split(line, cells, / *\| */)
        recorded[key(cells, count)] = line
      }
      rows = split(table, lines, "\n")
      columns = split(lines[1], names, / *\| */)
      for (r = 3; r <= rows; ++r) {
        count = split(lines[r], cells, / *\| */)
        row = key(cells, count)
        if (!(row in recorded)) { print file " has no row " row; bad = 1; continue }
        split(recorded[row], before, / *\| */)
        for (i = 2; i < count; ++i) {
          if (!number(cells[i])) continue
          change = cells[i] - before[i]
          if (change < 0) change = -change
          if (change <= 0.05 * before[i]) continue
          print row "| " names[i] ": " before[i] " is recorded, it is " cells[i]
          bad = 1
        }
      }
      exit bad
    }' >&2 || { echo "FAILED: counted figures have changed by more than 5 %; if they should, write the table again" >&2; return 1; }
}

# SPDX-License-Identifier: MIT
# shellcheck shell=sh
# For scripts that make a table of a page: source it.

# write_table BEGIN END TABLE FILE: the lines between the lines BEGIN and END of FILE become TABLE.
write_table() {
  awk -v begin="$1" -v end="$2" -v table="$3" '
    $0 == begin { print; print ""; print table; print ""; skip = found = 1 }
    $0 == end { skip = 0 }
    !skip { print }
    END { exit !found || skip }' "$4" >"$4.new" || { rm -f "$4.new"; echo "$4: has no $1 ... $2" >&2; return 1; }
  mv "$4.new" "$4"
}

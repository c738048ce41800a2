#!/bin/sh
# SPDX-License-Identifier: MIT
# Writes recorded_measurement.h again: simulated measurements of the oscillator's position for 20 s.
#   usage: record_measurement.sh path/to/nlo
set -eu
csv=$(mktemp)
trap 'rm -f "$csv"' EXIT
"$1" simulate van_der_pol --noise gaussian:0.5 --seed 7 --set simulation.horizon_s=20 -o "$csv" >&2
awk -F, '
  NR == 1 {
    for (i = 1; i <= NF; ++i) column[$i] = i
    print "// SPDX-License-Identifier: MIT"
    print "// A Van der Pol oscillator at 50 Hz for 20 s, whose position is measured with noise N(0, 0.5). The columns are the"
    print "// measurement and the true state, which is used to compute the error. record_measurement.sh made this file."
    print "#pragma once\n"
    print "struct Record {\n  float measured, x1, x2;\n};\n"
    print "inline constexpr Record kRecords[] = {"
    next
  }
  { printf "    {%.3ff, %.4ff, %.4ff},\n", $column["y_measured"], $column["x1"], $column["x2"] }
  END { print "};" }' "$csv" >"$(dirname "$0")/recorded_measurement.h"
command -v clang-format >/dev/null && clang-format -i "$(dirname "$0")/recorded_measurement.h"

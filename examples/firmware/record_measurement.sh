#!/bin/sh
# SPDX-License-Identifier: MIT
# Writes recorded_measurement.h anew: what a sensor of the oscillator's position would have said for 20 s.
#   usage: record_measurement.sh path/to/nlo
set -eu
csv=$(mktemp)
trap 'rm -f "$csv"' EXIT
"$1" simulate van_der_pol --noise gaussian:0.5 --seed 7 --set simulation.horizon_s=20 -o "$csv" >&2
awk -F, '
  NR == 1 {
    for (i = 1; i <= NF; ++i) column[$i] = i
    print "// SPDX-License-Identifier: MIT"
    print "// Van der Pol oscillator at 50 Hz for 20 s, its position measured with noise N(0, 0.5): the columns are the"
    print "// measurement and, to judge by, the true state. Made by record_measurement.sh."
    print "#pragma once\n"
    print "struct Record {\n  float measured, x1, x2;\n};\n"
    print "inline constexpr Record kRecords[] = {"
    next
  }
  { printf "    {%.3ff, %.4ff, %.4ff},\n", $column["y_measured"], $column["x1"], $column["x2"] }
  END { print "};" }' "$csv" >"$(dirname "$0")/recorded_measurement.h"
command -v clang-format >/dev/null && clang-format -i "$(dirname "$0")/recorded_measurement.h"

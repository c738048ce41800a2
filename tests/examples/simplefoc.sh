#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs the example examples/simplefoc as its page describes: trains, exports for SimpleFOC and flies in a loop with a
# simulated motor. With Hall sensors its speed must be better than that of the best low-pass, and the table of the page
# must agree.
#   simplefoc.sh NLO SOURCE_DIR
set -euo pipefail
nlo=$1 source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
fail() { echo "FAILED  $*" && exit 1; }
"$nlo" train "$source/examples/simplefoc/hall_motor.toml" -o hall -q >said.txt 2>&1 || { cat said.txt && fail 'nlo train'; }
"$nlo" export hall/model.json --target simplefoc -o sensor >said.txt 2>&1 || { cat said.txt && fail 'nlo export'; }
cc -std=c99 -O2 -c sensor/src/hall_motor.c -o pair.o
g++ -std=gnu++11 -O2 -Wall -Wextra -Wshadow -Wconversion -Werror -Isensor/src -I"$source/tests/codegen/shims/simplefoc" \
  "$source/tests/examples/simulated_motor.cpp" pair.o -o loop
./loop | tee table.txt
grep '^| [0-9]' "$source/examples/simplefoc/README.md" >page.txt
awk -F'|' 'NR == FNR { for (i = 2; i <= NF; ++i) page[FNR, i] = $i; rows = FNR; next }
  { for (i = 2; i < NF; ++i) if ($i < 0.7 * page[FNR, i] || $i > 1.3 * page[FNR, i]) { print "the page has" page[FNR, i] "and not" $i; bad = 1 } }
  FNR == 1 && !($3 < 0.6 * $5) { print "no better than a low-pass"; bad = 1 }
  END { exit bad || FNR != rows }' page.txt table.txt || fail 'the table of examples/simplefoc/README.md'

#!/bin/bash
# SPDX-License-Identifier: MIT
# Builds with the toolchain file of a board with Linux and runs its smallest program, and the same program on this
# machine: the estimates agree within the bound of the fast policy.
#   usage: minimal_linux.sh CMAKE SOURCE_DIR PROCESSOR BUILD_DIR NLO
set -euo pipefail
cmake=$1 source=$2 processor=$3 build=$4 nlo=$5
"$cmake" -S "$source" -B "$build" -G Ninja --toolchain "$source/toolchains/$processor.cmake" \
  -DCMAKE_BUILD_TYPE=Release -DNLO_PROGRAM="$nlo" >"$build.log" 2>&1 && "$cmake" --build "$build" >>"$build.log" 2>&1 ||
  { cat "$build.log"; exit 1; }
c++ -std=c++20 -O2 -I"$source/runtime/include" -I"$build/examples/minimal/nlo_models/minimal" \
  "$source/examples/minimal/minimal.cpp" -o "$build/minimal_here"

measurements=$(seq 1 40 | awk '{ print 2.5 * sin($1 / 5) }')
here=$("$build/minimal_here" <<<"$measurements")
there=$("qemu-$processor" -L "/usr/$processor-linux-gnu" "$build/examples/minimal/minimal" <<<"$measurements")
# Twice the bound of the fast policy for an estimate, 3e-6, because both programs use that policy.
paste <(echo "$here") <(echo "$there") | awk '
  function apart(a, b) { return a > b ? a - b : b - a }
  { for (i = 1; i <= 2; ++i) if (apart($i, $(i + 2)) > 6e-6) { print "FAILED  line " NR ": " $0; failed = 1 } }
  END { if (NR != 40) { print "FAILED  " NR " estimates of 40"; failed = 1 } else print "40 estimates, last: " $0; exit failed }'

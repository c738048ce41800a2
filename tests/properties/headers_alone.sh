#!/bin/sh
# SPDX-License-Identifier: MIT
# Each runtime header compiles alone, without warnings, exceptions and RTTI, for a target without an operating system;
# and all except nlo/eigen.h without Eigen.
#   usage: headers_alone.sh COMPILER SOURCE_DIR EIGEN_INCLUDE_DIR WORK_DIR
set -eu
compiler=$1 source=$2 eigen=$3 work=$4
mkdir -p "$work"
cd "$source" # relative paths: the flags below are split at spaces, which the path may contain
flags="-std=c++20 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror -fno-exceptions -fno-rtti
  -Iruntime/include -fsyntax-only -x c++ /dev/null"

# compile HEADER [FLAGS]: compiles /dev/null after the header, because `#pragma once` in a main file is a warning.
compile() {
  # shellcheck disable=SC2086
  "$compiler" $flags ${2:-} -include "$1"
}

failures=0 count=0
for header in $(cd "$source/runtime/include" && find nlo -name '*.h' | sort); do
  needs=-ffreestanding
  if [ "$header" = nlo/eigen.h ]; then needs="-isystem $eigen"; fi
  count=$((count + 1))
  compile "$header" "$needs" || { echo "FAILED   $header"; failures=$((failures + 1)); }
done
echo "$count headers, $failures with a complaint"

echo '#pragma once
inline float halve(float x) { return x * 0.5; }' >"$work/warns.h"
echo '#pragma once
inline vector missing();' >"$work/incomplete.h"
echo '#pragma once
#include <Eigen/Core>' >"$work/needs_eigen.h"
for control in warns incomplete needs_eigen; do
  if compile "$work/$control.h" 2>/dev/null; then
    echo "FAILED   control $control was not detected"
    failures=$((failures + 1))
  fi
done
[ "$count" -gt 4 ] && exit $((failures > 0))

#!/usr/bin/env bash
# Compilers read literals as the bits from which they were written, without a warning. A wrong bit is detected.
#   compile_literals.sh WRITE_LITERALS COMPILER
set -euo pipefail
write_literals=$1 compiler=$2
command -v "$compiler" >/dev/null || { echo "SKIPPED: no $compiler here"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

passes() {
  "$compiler" -std=c++20 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Werror "$work/$1.cpp" -o "$work/$1"
  "$work/$1"
}
"$write_literals" >"$work/literals.cpp"
passes literals || { echo "a literal is read as other bits than those that were written"; exit 1; }
"$write_literals" altered >"$work/control.cpp"
! passes control || { echo "a wrong bit was not detected"; exit 1; }

#!/bin/bash
# SPDX-License-Identifier: MIT
# The deterministic policy on the host: the golden bits, whatever the compiler is allowed to fuse, vectorise or leave
# unoptimised; and the plain versions of the Cortex-M kernels.
#   usage: host_parity.sh COMPILER SOURCE_DIR WORK_DIR
set -euo pipefail
compiler=$1 source=$2 work=$3
mkdir -p "$work"
strict=(-std=c++20 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror
  -I"$source" -I"$source/runtime/include")
failed=0

# run PROGRAM FLAG...: prints what it prints.
run() {
  local program=$1
  shift
  "$compiler" "${strict[@]}" "$@" "$source/tests/embedded/target/$program.cpp" -o "$work/$program" && "$work/$program"
}

# expect PROGRAM GOLDEN FLAG...
expect() {
  local program=$1 golden=$source/tests/golden/$2
  shift 2
  if run "$program" "$@" | diff "$golden" -; then echo "ok      $program $*"; else echo "FAILED  $program $*" && failed=1; fi
}

fused=()
if [[ $(uname -m) == x86_64 ]] && grep -qw fma /proc/cpuinfo; then fused=(-mavx2 -mfma -ffp-contract=fast); fi
for flags in -O0 '-O3 -march=native' "-O2 ${fused[*]}" '-O2 -DNLO_SCALAR_KERNELS'; do
  # shellcheck disable=SC2086
  expect parity parity.txt $flags
done
expect kernels kernels_cortex_m.txt -O2
expect int16 int16.txt -O2

# The control: the same program with fused arithmetic in the place of the deterministic one.
if ((${#fused[@]})) && run parity -O2 "${fused[@]}" -DNLO_PARITY_POLICY=kFast | diff -q "$source/tests/golden/parity.txt" - >"$work/control"; then
  echo 'FAILED  the control: fused arithmetic went unseen'
  failed=1
fi
exit "$failed"

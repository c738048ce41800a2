#!/bin/bash
# SPDX-License-Identifier: MIT
# Checks that a compiler gives the golden bits for the deterministic policy with any options for fusing, vectorising and
# optimising and for any CPU: kernels of RISC-V vectors or plain versions of Cortex-M kernels, int16, and floats.
#   usage: parity.sh COMPILER SOURCE_DIR WORK_DIR [RUNNER]
#   RUNNER runs the programs of a cross compiler, as qemu-aarch64 does.
set -euo pipefail
compiler=$1 source=$2 work=$3 runner=${4:-}
mkdir -p "$work"
strict=(-std=c++20 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror
  -I"$source" -I"$source/runtime/include")
if [[ -n $runner ]]; then strict+=(-static); fi # needs no library of the target then
failed=0

# run PROGRAM FLAG...: compiles a program, runs it and prints its output.
run() {
  local program=$1
  shift
  "$compiler" "${strict[@]}" "$@" "$source/tests/embedded/target/$program.cpp" -o "$work/$program" && $runner "$work/$program"
}

# expect PROGRAM GOLDEN FLAG...
expect() {
  local program=$1 golden=$source/tests/golden/$2
  shift 2
  if run "$program" "$@" | diff "$golden" -; then echo "ok      $program $*"; else echo "FAILED  $program $*" && failed=1; fi
}

fused=() # flags by which the compiler may fuse, where the target can
variants=(-O0 -O2)
case $("$compiler" -dumpmachine) in
  x86_64*)
    variants+=(-O3 '-O2 -DNLO_SCALAR_KERNELS' '-O2 -DNLO_CPU_DISPATCH' '-O2 -march=x86-64-v2')
    if grep -qw fma /proc/cpuinfo; then fused=(-march=x86-64-v3 -ffp-contract=fast); fi
    if grep -qw avx512vl /proc/cpuinfo; then variants+=('-O3 -march=x86-64-v4 -ffp-contract=fast'); fi
    variants+=('-O3 -march=native')
    ;;
  riscv64*)
    export QEMU_CPU=rv64,v=true,vext_spec=v1.0,vlen=128 # g++ 12 uses vectors only in assembly, and only with -march
    variants+=('-O0 -march=rv64gcv' '-O2 -march=rv64gcv')
    fused=(-march=rv64gcv -ffp-contract=fast)
    ;;
  *) fused=(-ffp-contract=fast) ;;
esac
if ((${#fused[@]})); then variants+=("-O3 ${fused[*]}"); fi
for flags in "${variants[@]}"; do
  # shellcheck disable=SC2086
  expect parity parity.txt $flags
done
if [[ -z $runner ]]; then expect kernels kernels_cortex_m.txt -O2; fi # plain C++, which takes long to compile
expect int16 int16.txt -O2
expect floats floats.txt -O2
if [[ -n ${QEMU_CPU:-} ]]; then
  for vlen in 128 256; do # the bits must not depend on the vector length
    export QEMU_CPU=${QEMU_CPU%=*}=$vlen
    expect kernels kernels_cortex_m.txt -O2 -march=rv64gcv
    expect int16 int16.txt -O2 -march=rv64gcv
  done
fi

# Control: the same program with fused instead of deterministic arithmetic must differ.
if ((${#fused[@]})) && run parity -O2 "${fused[@]}" -DNLO_PARITY_POLICY=kFast | diff -q "$source/tests/golden/parity.txt" - >"$work/control"; then
  echo 'FAILED  the control: fused arithmetic was not detected'
  failed=1
fi
exit "$failed"

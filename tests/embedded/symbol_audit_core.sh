#!/bin/sh
# SPDX-License-Identifier: MIT
# Audits the external symbols on a core: step, estimate and all functions that start an observer may reference only
# memcpy, memset and memmove, at each optimisation level; without an FPU also the compiler's functions for single
# precision. A double would be a mistake on every core.
#   usage: symbol_audit_core.sh SOURCE_DIR WORK_DIR PATTERN FLAG...
set -eu
source=$1 work=$2 floats=$3
shift 3
mkdir -p "$work"
allowed="memcpy|memset|memmove|__aeabi_mem(cpy|set|clr|move)[48]?${floats:+|$floats}"
failures=0

# outside OBJECT: prints the symbols that it needs but may not use.
outside() { arm-none-eabi-nm -u "$1" | awk '{ print $NF }' | grep -vxE "$allowed"; }

for level in -O0 -Os -O2 -O3; do
  arm-none-eabi-g++ "$@" -std=c++20 $level -fno-exceptions -fno-rtti -fno-unwind-tables -I"$source" \
    -I"$source/runtime/include" -c "$source/tests/embedded/target/audited.cpp" -o "$work/audited.o"
  if outside "$work/audited.o"; then
    echo "FAILED   $level needs the symbols above"
    failures=1
  else
    echo "ok       $level: $(arm-none-eabi-nm -u "$work/audited.o" | awk '{ print $NF }' | tr '\n' ' ')"
  fi
done

# Control: one double in the loop must be found.
arm-none-eabi-g++ "$@" -std=c++20 -O2 -DNLO_CONTROL -I"$source" -I"$source/runtime/include" -fno-exceptions -fno-rtti \
  -fno-unwind-tables -c "$source/tests/embedded/target/audited.cpp" -o "$work/control.o"
outside "$work/control.o" >/dev/null || { echo 'FAILED   the control: a double was not detected'; failures=1; }
exit $failures

#!/bin/sh
# SPDX-License-Identifier: MIT
# Checks that an observer in flight calls only memcpy, memset and memmove, for each compiler and optimisation level, and
# that none of its code runs before main.
#   usage: symbol_audit.sh COMPILER SOURCE_DIR EIGEN_INCLUDE_DIR WORK_DIR
set -eu
compiler=$1 source=$2 eigen=$3 work=$4
mkdir -p "$work"
cd "$source" # relative paths: the flags below are split at spaces, which the path may contain
flags="-std=c++20 -fno-exceptions -fno-rtti -I. -Iruntime/include -isystem $eigen"

# audit OBJECT: prints its forbidden symbols; succeeds without output if there are none.
audit() {
  bad=$(nm -u "$1" | awk '{print $NF}' | grep -vxE 'memcpy|memset|memmove|_GLOBAL_OFFSET_TABLE_' || true)
  if readelf -S -W "$1" | grep -qE '\.(init_array|ctors|preinit_array)'; then bad="$bad start-up-code"; fi
  nm "$1" | grep -q audited_loop || bad="$bad no-audited-loop"
  [ -z "$bad" ] || { echo "$bad"; return 1; }
}

failures=0
for level in -O0 -Os -O2 -O3; do
  # shellcheck disable=SC2086
  "$compiler" $flags $level -c "$source/tests/properties/audit/flies.cpp" -o "$work/flies.o"
  if found=$(audit "$work/flies.o"); then
    echo "ok       flies $level: $(nm -u "$work/flies.o" | awk '{print $NF}' | tr '\n' ' ')"
  else
    echo "FAILED   flies $level: it needs $found"
    failures=$((failures + 1))
  fi
  for control in 1 2 3 4 5; do
    # shellcheck disable=SC2086
    "$compiler" $flags $level -DCONTROL=$control -c "$source/tests/properties/audit/controls.cpp" -o "$work/control.o"
    if found=$(audit "$work/control.o"); then
      echo "FAILED   control $control $level was not detected"
      failures=$((failures + 1))
    else
      echo "detected control $control $level:" $found
    fi
  done
done
exit $((failures > 0))

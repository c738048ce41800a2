#!/bin/sh
# SPDX-License-Identifier: MIT
# One program may link objects that were compiled for different instruction sets: each runs its own functions. The object
# for any x86-64 runs on an emulated CPU without AVX, and has the same bits in both link orders.
#   usage: two_instruction_sets.sh COMPILER SOURCE_DIR EIGEN_INCLUDE_DIR WORK_DIR
set -eu
compiler=$1 source=$2 work=$4
command -v qemu-x86_64 >/dev/null || { echo 'skipped: no qemu-x86_64' && exit 0; }
mkdir -p "$work"
cp -r "$source/runtime/include" "$source/tests/golden/tiny.h" "$work"
cd "$work"
old_cpu='qemu-x86_64 -cpu Nehalem' # no AVX

for object in old new; do
  cat >$object.cpp <<SOURCE
#include "tiny.h"
static nlo::tiny::Observer observer{nlo::tiny::kModel};
float run_$object() {
  float sum = 0;
  for (int i = 0; i < 100; ++i) {
    (void)observer.step(0.01F * static_cast<float>(i));
    sum += observer.estimate()[0];
  }
  return sum;
}
SOURCE
done
cat >main.cpp <<'SOURCE'
#include <cstdio>
float run_old();
float run_new();
int main(int words, char**) { std::printf("%a\n", static_cast<double>(words == 1 ? run_old() : run_new())); }
SOURCE

# answers HEADERS LEVEL: the answer of the old object in both link orders, a line each
answers() {
  "$compiler" -std=c++20 "$2" -I"$1" -I. -c old.cpp -o old.o
  "$compiler" -std=c++20 "$2" -march=x86-64-v3 -I"$1" -I. -c new.cpp -o new.o
  for order in 'old.o new.o' 'new.o old.o'; do
    # shellcheck disable=SC2086
    "$compiler" main.cpp $order -o program
    $old_cpu ./program 2>/dev/null || echo 'illegal instruction'
  done
}

failed=0
for level in -O0 -O2; do
  found=$(answers include $level | sort -u)
  case $found in
    0x*) [ "$(echo "$found" | wc -l)" -eq 1 ] || { echo "FAILED   $level: the link order matters: $found" && failed=1; } ;;
    *) echo "FAILED   $level: $found" && failed=1 ;;
  esac
done

# The control: with one namespace for both instruction sets the linker mixes them.
cp -r include one_namespace
printf '#undef NLO_ISA\n#define NLO_ISA isa\n' >>one_namespace/nlo/kernels/compiler.h
answers one_namespace -O0 | grep -q 'illegal instruction' || { echo 'FAILED   control: one namespace works, too' && failed=1; }
[ "$failed" -eq 0 ] && echo 'objects for x86-64 and x86-64-v3 run side by side'
exit "$failed"

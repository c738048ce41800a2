#!/bin/sh
# SPDX-License-Identifier: MIT
# Step, estimate and in_domain of the deterministic policy are constant-time: callgrind counts the same number of
# instructions for a thousand samples of each kind. The counts, also those of the fast policy, must agree with
# tests/golden/instruction_counts.txt to 5 % (NLO_UPDATE_GOLDENS=1 writes that file).
#   usage: instruction_count.sh COMPILER SOURCE_DIR EIGEN_INCLUDE_DIR WORK_DIR
set -eu
compiler=$1 source=$2 eigen=$3 work=$4
mkdir -p "$work"
golden=$source/tests/golden/instruction_counts.txt
kinds='zeros random subnormal nan infinite extreme turning mixed'
samples=1000

# spread FLAGS...: compiles, counts each kind, prints the counts and stores the largest difference in $difference.
# Only architectures that valgrind 3.19 knows: no AVX-512.
spread() {
  "$compiler" -std=c++20 -I"$source" -I"$source/runtime/include" -isystem "$eigen" "$@" \
    "$source/tests/properties/audit/counted.cpp" -o "$work/counted"
  least= most=
  for kind in $kinds; do
    if ! valgrind --tool=callgrind --callgrind-out-file=/dev/null --toggle-collect=counted "$work/counted" "$kind" \
      >"$work/said.txt" 2>"$work/valgrind.txt"; then
      cat "$work/valgrind.txt"
      exit 1
    fi
    count=$(sed -n 's/.*Collected : *\([0-9]*\).*/\1/p' "$work/valgrind.txt")
    if [ "${count:-0}" -lt $((100 * samples)) ]; then
      echo "FAILED   nothing was counted: \"$count\" for $kind"
      exit 1
    fi
    echo "         $kind: $count ($(cat "$work/said.txt"))"
    if [ -z "$least" ] || [ "$count" -lt "$least" ]; then least=$count; fi
    if [ -z "$most" ] || [ "$count" -gt "$most" ]; then most=$count; fi
  done
  difference=$((most - least))
}

# recorded FLAGS...: fails unless the count agrees with the recorded one to 5 %.
recorded() {
  what="$(basename "$compiler") $*"
  if [ -n "${NLO_UPDATE_GOLDENS:-}" ]; then
    { grep -v "^$what: " "$golden" || true; echo "$what: $least"; } | LC_ALL=C sort >"$golden.new"
    mv "$golden.new" "$golden"
  fi
  before=$(sed -n "s/^$what: //p" "$golden")
  change=$((least - ${before:-0}))
  if [ $((20 * ${change#-})) -gt "${before:-0}" ]; then
    echo "FAILED   $least instructions, where $golden has ${before:-none}"
    failures=$((failures + 1))
  fi
}

failures=0
check() {
  echo "counting $*"
  spread "$@"
  if [ "$difference" -eq 0 ]; then
    echo "ok       $least instructions for each kind"
    recorded "$@"
  else
    echo "FAILED   $least instructions and up to $difference more"
    failures=$((failures + 1))
  fi
}
check -O2 -DNLO_ACTIVATION=kTanh
check -O3 -march=x86-64-v3 -DNLO_ACTIVATION=kRelu
check -O2 -march=x86-64-v3 -DNLO_ACTIVATION=kSilu -DANGLE

# Controls: a branch on the status, and the fast policy, whose validation branches.
kinds='zeros nan extreme'
for control in -DCONTROL=1 -DCONTROL=2; do
  echo "control $control"
  spread -O2 -DNLO_ACTIVATION=kTanh $control
  if [ "$difference" -gt 0 ]; then
    echo "detected up to $difference more than $least"
    if [ "$control" = -DCONTROL=2 ]; then recorded -O2 -DNLO_ACTIVATION=kTanh fast; fi
  else
    echo "FAILED   control $control was not detected"
    failures=$((failures + 1))
  fi
done
exit $((failures > 0))

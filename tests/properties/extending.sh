#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Tests docs/extending.md: a copy of the tree with all its diffs builds, passes the tests of the diffs and the tests
# over the tables, and each diff has its effect.
#   usage: extending.sh SOURCE_DIR WORK_DIR CMAKE CTEST
set -euo pipefail
source=$(cd "$1" && pwd) work=$2 cmake=$3 ctest=$4
rm -rf "$work"
mkdir -p "$work/tree" "$work/run"
work=$(cd "$work" && pwd)
export GIT_CEILING_DIRECTORIES="${work%/*}"
fail() { echo "FAILED: $1"; exit 1; }

tar -C "$source" --exclude=./build --exclude=./.git --exclude=./runs -cf - . | tar -C "$work/tree" -xf -
cd "$work/tree"
mapfile -t diffs < <(sed -n 's/^git apply \(docs\/extending\/[a-z]*\.diff\)$/\1/p' docs/extending.md)
for diff in "${diffs[@]}"; do git apply "$diff" || fail "$diff does not apply"; done

# Programs with the tests of a diff, or with tests over a table to which a diff adds a row.
programs=(base_test codegen_test commands_test compare_test kernels_blocked_test losses_test nn_test
  observer_structures_test optim_test plants_test structures_test training_test)
step() { echo "-- $1 ($SECONDS s)"; }
step "configure"
"$cmake" -S . -B build -G Ninja -DCMAKE_BUILD_TYPE=Release -DNLO_BENCH=OFF -DNLO_EXAMPLES=OFF >"$work/configure.log" 2>&1 ||
  { tail -30 "$work/configure.log"; fail "it does not configure"; }
step "build"
"$cmake" --build build --target nlo nlo_export_model "${programs[@]}" >"$work/build.log" 2>&1 ||
  { grep -E "error|warning" "$work/build.log" | head -20; fail "it does not build: $work/build.log"; }
step "tests"
chosen='^(codegen_test\.(Activations|EachActivation|EachTrainedActivation|Export|Facts|ModelFile.*|ReferenceObserver)'
chosen+='|base_test\.Table/EveryNoise|compare_test\.FilterSearch|optim_test\..*|commands_test\.(InfoCommand|CommandLine)|kernels_blocked_test\..*|losses_test\..*|nn_test\..*'
chosen+='|observer_structures_test\..*|plants_test\.(EveryPlant|Pendulum)|structures_test\.StaticMap|training_test\.Objective)$'
"$ctest" --test-dir build -R "$chosen" --no-tests=error --output-on-failure >"$work/tests.log" 2>&1 ||
  { tail -60 "$work/tests.log"; fail "its tests fail"; }
for own in Pendulum StaticMap Facts InfoCommand kernels_blocked_test losses_test EachActivation Objective; do
  grep -q "$own.* Passed" "$work/tests.log" || fail "no test of $own was run"
done

step "commands"
nlo=$work/tree/build/trainer/nlo
cd "$work/run"
cat >new.toml <<'TOML'
name = "added"

[plant]
model = "pendulum"
parameters = {damping = 0.2}

[simulation]
horizon_s = 12.0
sample_period_s = 0.05
trajectories = 4
initial_low = [-1, -1]
initial_high = [1, 1]

[observer]
structure = "static_map"

[inverse_map]
hidden = [8]
activation = "lisht"

[loss]
robust_error = 0.5

[training]
steps = 20
trajectories_per_step = 4
samples_per_step = 64
TOML
"$nlo" simulate new.toml -o pendulum.csv || fail "the new plant cannot be simulated"
[ "$(wc -l <pendulum.csv)" -gt 200 ] || fail "the new plant has no trajectory"
"$nlo" train new.toml -q -o static_map || fail "the new structure, loss and activation cannot be trained"
"$nlo" train new.toml -q -o kkl --set 'observer.structure="kkl"' --set 'observer.eigenvalues=[-1.0, -2.0, -3.0]' ||
  fail "the new loss and activation cannot be trained in a KKL observer"
"$nlo" train new.toml -q -o lion --set 'training.optimiser="lion"' --set 'training.noise="laplace:0.1"' ||
  fail "the new optimiser and noise cannot train"
"$nlo" compare lion/model.json --against open_loop --trajectories 2 -q -o compared >/dev/null ||
  fail "the new filter cannot be compared with"
"$nlo" simulate plants/cart_and_pendulum --set 'excitation.kinds=["sawtooth"]' -o driven.csv ||
  fail "the new kind of input excites no plant"
"$nlo" info static_map/model.json | grep "^structure  static_map$" >/dev/null || fail "the new command does not name the structure"
"$nlo" info kkl/model.json | grep "^map        inverse_map lisht 4-8-2$" >/dev/null || fail "the new command does not show the map"
for name in static_map kkl; do
  "$nlo" export $name/model.json --name ${name}_new -q -o ${name}_new.h
  "$nlo" export $name/model.json --name ${name}_new -q --target replay -o ${name}_new_replay.h
  "$nlo" export $name/model.json -q --target facts -o $name.md
  grep -q '^| `x2` | - | estimated' $name.md || fail "the new target does not name the states of $name"
done
"$nlo" export kkl/model.json -q --target c99 --name kkl_c99 -o kkl_c99.h
cc -std=c99 -Wall -Wextra -Werror -c kkl_c99.c || fail "C99 with the new activation does not compile"
cat >fly.cpp <<'CPP'
#include "kkl_new.h"
#include "kkl_new_replay.h"
#include "static_map_new.h"
#include "static_map_new_replay.h"
int main() {
  nlo::kkl_new::Observer kkl{nlo::kkl_new::kModel};
  nlo::static_map_new::Observer static_map{nlo::static_map_new::kModel};
  return nlo::kkl_new::replay::first_mismatch(kkl) == -1 && nlo::static_map_new::replay::first_mismatch(static_map) == -1 ? 0 : 3;
}
CPP
# With the instructions of the target, and with the new kernel.
for kernel in "" "-DNLO_SCALAR_KERNELS -DNLO_BLOCKED_KERNELS"; do
  c++ -std=c++20 -O1 -Wall -Wextra -Werror $kernel -I "$work/tree/runtime/include" -I . fly.cpp -o fly
  ./fly || fail "an exported observer answers otherwise than its equations (${kernel:-default kernels})"
done
step "passed"

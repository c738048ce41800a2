#!/bin/bash
# SPDX-License-Identifier: MIT
# What `nlo export --fit` says against linked programs: never less than they take, and not much more.
#   usage: fit.sh NLO EXPORT_MODEL SOURCE_DIR WORK_DIR CORE BOARD FLAG...
set -euo pipefail
nlo=$1 export_model=$2 source=$3 work=$4 core=$5 board=$6
shift 6
cross=("$@" -ffunction-sections -fdata-sections)
slack_bytes=1200 slack_percent=5 # of flash; of the stack 200 bytes: see the table in codegen/export/fit.cpp
slack_stack=200
failed=0
rm -rf "$work" && mkdir -p "$work"

# judge WHAT REAL SAID LIMIT
judge() {
  local outcome=ok
  if [[ ! $2 =~ ^[0-9]+$ || ! $3 =~ ^[0-9]+$ ]]; then
    outcome='FAILED: no number'
  elif (($3 < $2)); then
    outcome='FAILED: less than it takes'
  elif (($3 > $4)); then
    outcome="FAILED: more than $4"
  fi
  echo "$1: takes $2, said $3, $outcome"
  [[ $outcome == ok ]] || failed=1
}

source "$source/bench/embedded/stack_bound.sh"

arm-none-eabi-gcc "${cross[@]}" -c "$source/toolchains/cortex_m/startup.S" -o "$work/startup.o"
arm-none-eabi-gcc "${cross[@]}" -O2 -c "$source/toolchains/cortex_m/semihosting.c" -o "$work/semihosting.o"

for model in van_der_pol rig tiny tiny_relu tiny_tanh linear shipped; do
  if [[ $model == shipped ]]; then
    cp "$source/examples/models/van_der_pol.json" "$work/$model.json"
  else
    "$export_model" $model model float $model "$work/$model.json"
  fi
  for scalar in float int16; do
    name=fit_${model}_$scalar
    said=$("$nlo" export "$work/$model.json" --scalar $scalar --name "$name" --fit core="$core" -o "$work/$name.h" |
      awk -v core="$core" 'BEGIN { title["m0plus"] = "M0+"; title["m4f"] = "M4F"; title["m7"] = "M7"; title["m33"] = "M33" }
        $1 == title[core] { print $2, $9 }')
    read -r said_flash said_stack <<<"$said"
    cat >"$work/$name.cpp" <<END_OF_PROGRAM
#include "$name.h"
constinit static nlo::$name::Observer observer{nlo::$name::kModel};
volatile float measured;
volatile float estimated;
extern "C" __attribute__((noinline)) void step_and_estimate() {
  nlo::$name::Observer::Output y{};
  for (int j = 0; j < nlo::$name::Model::kNy; ++j) y[j] = measured;
  static_cast<void>(observer.step(y));
  for (const float x : observer.estimate()) estimated = x;
}
int main() {
  for (;;) step_and_estimate();
}
END_OF_PROGRAM
    arm-none-eabi-g++ -std=c++20 -O2 -DNDEBUG -fno-exceptions -fno-rtti -fno-threadsafe-statics -fno-unwind-tables \
      -fno-asynchronous-unwind-tables "${cross[@]}" -fcallgraph-info=su -I"$source/runtime/include" \
      -c "$work/$name.cpp" -o "$work/$name.o"
    arm-none-eabi-g++ "${cross[@]}" "$work/$name.o" "$work/startup.o" "$work/semihosting.o" -nostartfiles \
      --specs=nano.specs --specs=nosys.specs -L"$source/toolchains/cortex_m" -T"$board.ld" -Wl,--gc-sections \
      -Wl,--no-warn-rwx-segments -o "$work/$name.elf"
    flash=$(arm-none-eabi-size "$work/$name.elf" | awk 'NR == 2 { print $1 + $2 }')
    stack=$(stack_bound "$work/$name.ci")
    judge "$core $model $scalar flash" "$flash" "$said_flash" $((flash * (100 + slack_percent) / 100 + slack_bytes))
    judge "$core $model $scalar stack" "$stack" "$said_stack" $((stack + slack_stack))
  done
done

# The control: a table that is wrong either way is seen.
before=$failed
for said in 99 201 ''; do
  failed=0
  judge "control" 100 "$said" 200 >/dev/null
  ((failed)) || { echo "judge() takes \"$said\" for 100 to 200"; exit 1; }
done
exit "$before"

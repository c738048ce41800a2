#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Folders for other frameworks, around the C99 pair, as far as they go without those: against shims of their headers they
# compile without a warning, and give the bits of the pair under sanitizers; a control shows that it would be seen.
#   compile_wrappers.sh EXPORT_MODEL SOURCE_DIR
set -euo pipefail
export_model=$1 source=$2 shims=$2/tests/codegen/shims
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
warnings=(-Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror)
sanitizers=(-O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all)
fail() { echo "FAILED  $*" && exit 1; }

# sfunction FOLDER NAME SCALAR OUTPUT: the block and the engine of the shim.
sfunction() {
  local driven=() period
  if grep -q "$2_NU" "$1/$2.h"; then driven=(-DNLO_DRIVEN); fi
  period=$(sed -n 's/.*ssSetSampleTime(S, 0, \(.*\));/\1/p' "$1/$2_sfun.c")
  gcc -std=c99 "${warnings[@]}" "${sanitizers[@]}" -I"$source" -I"$shims/simulink" -I"$1" -DNLO_NAME="$2" -DNLO_SCALAR="${3/int16/float}" \
    -DNLO_PERIOD="$period" "${driven[@]}" -include "$work/$2_replay.h" "$1/$2_sfun.c" "$1/$2.c" -lm -o "$4"
}

for entry in rig:double commanded:int16 gated:float; do
  name=${entry%:*} scalar=${entry#*:} folder=$work/simulink_$name
  "$export_model" "$name" simulink "$scalar" "$name" "$folder"
  "$export_model" "$name" replay-c99 "$scalar" "$name" "$work/${name}_replay.h"
  sfunction "$folder" "$name" "$scalar" "$work/block"
  "$work/block" || fail "the S-function of $entry"
  for file in "${name}_sfun.c" "$name.c"; do grep -q "'$file'" "$folder/build_$name.m" || fail "build_$name.m leaves out $file"; done
  echo "ok      simulink $entry"
done
sed -i 's/memcpy(ssGetDWork(S, kNext), &observer/memcpy(ssGetDWork(S, kNow), \&observer/' "$folder/${name}_sfun.c"
sfunction "$folder" "$name" "$scalar" "$work/block"
! "$work/block" >"$work/said.txt" || fail 'outputs that move the state went unseen'

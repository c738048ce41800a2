#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs Frama-C's EVA on exported C99 pairs under any_flight.c: no alarm, and each assertion of that file is proven.
# Controls: a loop bound that is one too large; a step without the check of z.
#   eva.sh EXPORT_MODEL SOURCE_DIR [EXAMPLE:SCALAR...]   without pairs: all that C99 supports
set -euo pipefail
export_model=$1 source=$(cd "$2" && pwd)
shift 2
command -v frama-c >/dev/null || { echo 'SKIPPED: no frama-c here'; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

pairs=("$@")
if (($# == 0)); then
  for example in $("$export_model"); do pairs+=("$example:float" "$example:double" "$example:int16"); done
fi

# write NAME EXAMPLE SCALAR: exports; fails if there is no such export.
write() {
  "$export_model" "$2" c99 "$3" "$1" "$work/$1.h" 2>"$work/refused.txt" && return
  (($# > 3)) && grep -qE 'target c99 writes|^int16 ' "$work/refused.txt" || { cat "$work/refused.txt" >&2 && exit 1; }
  return 1
}

# analysed NAME SCALAR: prints EVA's result for the pair.
analysed() {
  local name=$1 header=$work/$1.h c=$work/$1.c type=float largest=0x1p100f inputs angles settles options=()
  if [[ $2 == double ]]; then type=double largest=0x1p100; fi
  inputs=$(sed -n "s/.* ${name}_NU = \([0-9]*\).*/\1/p" "$header")
  angles=$(sed -n 's/^static const IN_FLASH Scalar kWrap\[.*= \({.*}\);.*/\1/p' "$c")
  {
    printf '#include "%s.h"\n#define NAME %s\n#define SCALAR %s\n#define LARGEST %s\n' "$name" "$name" $type $largest
    printf '#define TURNS %s\n' "${angles:-{[sizeof(((${name}_observer*)0)->y) / sizeof($type) - 1] = 0\}}"
    if [[ $inputs ]]; then echo "#define INPUTS $inputs"; fi
    settles=$(grep "${name}_warm_start" "$header" || true)
    if [[ $settles ]]; then echo '#define SETTLES'; fi
    if [[ $settles && $settles != *' u['* ]]; then echo '#define SETTLES_BY_Y'; fi
    if grep -q "${name}_watch(" "$header"; then echo '#define WATCHED'; fi
    if grep -q "${name}_staleness" "$header"; then echo '#define STALENESS'; fi
    if grep -q make_unit "$c"; then echo '#define UNIT_LENGTH'; fi # a quotient of 1 at most, which is a relation
    echo "#include \"$source/tests/proofs/any_flight.c\""
  } >"$work/${name}_flight.c"
  # EVA cannot know that the table of tanh is increasing, so that its differences fit their type.
  if [[ $2 != int16 ]]; then options=(-warn-signed-downcast -warn-unsigned-downcast); fi
  frama-c -eva -cpp-extra-args="-I$work" -warn-special-float none -warn-invalid-pointer "${options[@]}" \
    -eva-slevel 0 -eva-slevel-function "is_reachable:400,is_sound:2000,${name}_restore:2000,take:10,checked:50" \
    -eva-split-return auto -eva-auto-loop-unroll 600 -eva-subdivide-non-linear 16 \
    -eva-domains equality,symbolic-locations "$c" "$work/${name}_flight.c" 2>&1
}

# proven NAME: succeeds if EVA reached all code and raised no alarm.
proven() {
  ! grep -qE 'got status (unknown|invalid)|rror:|\[kernel\] (User|Frama-C) Error' "$work/$1.txt" &&
    grep -q '0 errors .* 0 warnings' <(grep 'Eva analyzer' "$work/$1.txt") &&
    grep -q ' 0 alarms generated' "$work/$1.txt" && grep -qE 'Assertions +[1-9][0-9]* valid +0 unknown +0 invalid' "$work/$1.txt"
}

failed=0
for pair in "${pairs[@]}"; do
  scalar=${pair#*:} name=${pair%:*}_$scalar
  if (($# == 0)); then write "$name" "${pair%:*}" "$scalar" any || continue; else write "$name" "${pair%:*}" "$scalar"; fi
  analysed "$name" "$scalar" >"$work/$name.txt" || true
  if proven "$name"; then
    echo "ok      $pair"
  else
    echo "FAILED  $pair" && failed=1
    grep -A 2 -E 'alarm\]|got status|rror' "$work/$name.txt" || tail "$work/$name.txt"
  fi
done

write control tiny float
cp "$work/control.c" "$work/good.c"
for control in 's/channel >= 1/channel > 1/' 's/ && (z\[r\] < kLargest)//'; do
  sed "$control" "$work/good.c" >"$work/control.c"
  ! cmp -s "$work/good.c" "$work/control.c" || { echo "FAILED  the control changed nothing: $control" && failed=1; }
  analysed control float >"$work/control.txt" || true
  ! proven control || { echo "FAILED  the control was not detected: $control" && failed=1; }
done
exit $failed

#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# C99 exports of all examples that it supports: strict C without warnings, no undefined symbol, the golden replay, and
# the bits of the C++ runtime's deterministic policy at each optimisation level. Controls show that each fault would be
# detected. The same for the single C++ header, which must also compile alone and in two translation units, and be
# short.
#   compile_c99.sh EXPORT_MODEL SOURCE_DIR C_COMPILER C++_COMPILER
set -euo pipefail
export_model=$1 source=$2 cc=$3 cxx=$4
command -v "$cc" >/dev/null && command -v "$cxx" >/dev/null || { echo "SKIPPED: no $cc here"; exit 77; }
tests=$source/tests/codegen/c99
# shellcheck source=/dev/null
source "$tests/drive.sh"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/cpp" "$work/single"
warnings=(-Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror)
strict=(-std=c99 "${warnings[@]}" -Wstrict-prototypes -Wmissing-prototypes)

# Lists the examples that C99 supports. A new structure may be refused.
examples() {
  local example
  for example in $("$export_model"); do
    if "$export_model" "$example" c99 float "$example" "$work/$example.h" 2>"$work/refused.txt"; then
      echo "$example"
    else
      grep -q 'target c99 writes' "$work/refused.txt" || { cat "$work/refused.txt" >&2 && exit 1; }
    fi
  done
}

# The C++ runtime behind the C header of NAME.
shim() {
  local driven=
  if grep -q "$1_NU" "$work/$1.h"; then driven=DRIVEN_; fi
  echo "NLO_C99_${driven}SHIM($1, $2)"
  if grep -q "$1_warm_start" "$work/$1.h"; then
    if ! grep -q "$1_warm_start.* u\[" "$work/$1.h"; then driven=; fi
    echo "NLO_C99_${driven}WARM_SHIM($1, $2)"
  fi
  if grep -q "$1_watch(" "$work/$1.h"; then echo "NLO_C99_WATCHED_SHIM($1, $2)"; fi
}

names=()
for entry in encoder:float rig:double carried:double tiny:double van_der_pol:int16 rig:int16 tiny_relu:int16 tiny_silu:int16 linear:int16 commanded:int16 failing:double two_rates:double two_rates:int16 clocked:double clocked:int16 clocked_rig:int16 fallback:double fallback:int16 computed:double computed:int16 saturating_rig:double saturating:int16 gated:double failing_gated:double commanded_gated:int16 gated:int16 prior:double prior_functions:double filter:double filter_functions:double driven:double watched_rig:double watched:int16 commanded_pendulum:double commanded_general:int16 general:double $(examples | sed 's/$/:float/'); do
  example=${entry%:*} scalar=${entry#*:} name=$example
  if [[ $scalar != float ]]; then name=${example}_$scalar; fi
  names+=("$name:${scalar/int16/float}") # all except T* is float
  "$export_model" "$example" c99 "$scalar" "$name" "$work/$name.h"
  "$export_model" "$example" replay-c99 "$scalar" "$name" "$work/${name}_replay.h"
  "$export_model" "$example" cpp "$scalar" "$name" "$work/cpp/$name.h"
  "$export_model" "$example" single "$scalar" "$name" "$work/single/$name.h"
done
sources=() objects=()
for entry in "${names[@]}"; do sources+=("$work/${entry%:*}.c") && objects+=("$work/${entry%:*}.o"); done

# One program for all examples, the C++ runtime behind the same headers, and a check of the sizes that headers state.
{
  for entry in "${names[@]}"; do
    name=${entry%:*}
    drive_of "$name" "${entry#*:}" "$work/$name.h"
    bytes=$(sed -n 's|.*n observer takes \([0-9]*\) bytes of RAM.*|\1|p' "$work/$name.h")
    echo "typedef char ${name}_has_its_size[sizeof(${name}_observer) == $bytes ? 1 : -1];"
  done
  echo "int main(void) { return 0"
  for entry in "${names[@]}"; do echo "  + ${entry%:*}_drive()"; done
  echo "  ; }"
} >"$work/main.c"
for form in cpp single; do
  {
    for entry in "${names[@]}"; do
      name=${entry%:*}
      echo "#include \"$work/$name.h\""
      echo "#include \"$work/$form/$name.h\""
    done
    echo "#include \"$tests/shim.h\""
    for entry in "${names[@]}"; do shim "${entry%:*}" "${entry#*:}"; done
  } >"$work/shim_$form.cpp"
done

"$cc" "${strict[@]}" -I "$source" -O1 -c "$work/main.c" -o "$work/main.o"
"$cxx" -std=c++20 "${warnings[@]}" -O1 -I "$source/runtime/include" -c "$work/shim_cpp.cpp" -o "$work/shim.o"
"$cxx" "$work/main.o" "$work/shim.o" -o "$work/want" && "$work/want" >"$work/want.txt"

contracted=-ffp-contract=fast
if [[ $cc == *clang* ]]; then contracted=-ffp-contract=on; fi # clang's `fast` would override the pragma of the file
failed=0
for flags in '-std=c99 -O0' '-std=c99 -Os' '-std=c99 -O2' "-std=gnu11 -O3 -march=native $contracted"; do
  # shellcheck disable=SC2086
  (cd "$work" && "$cc" "${strict[@]}" $flags -c "${sources[@]}")
  for entry in "${names[@]}"; do
    undefined=$(nm -u "$work/${entry%:*}.o")
    [ -z "$undefined" ] || { echo "FAILED  ${entry%:*} $flags references $undefined" && failed=1; }
  done
  "$cc" "$work/main.o" "${objects[@]}" -o "$work/got"
  if "$work/got" | diff "$work/want.txt" -; then echo "ok      $flags"; else echo "FAILED  $flags" && failed=1; fi
done
cat "$work/want.txt"
grep -q '^watched + + + + + + + ' "$work/want.txt" || { echo 'FAILED  the run did not raise each alarm of the monitor' && failed=1; }

# An encoder for 20 minutes: the bits of the C++ runtime, and the speed. Control: without the wrap, readings are
# clamped.
mkdir "$work/encoder"
cp "$work/encoder.c" "$work/encoder.h" "$work/encoder"
{
  echo "#include \"$work/encoder.h\""
  echo "#include \"$work/cpp/encoder.h\""
  echo "#include \"$tests/shim.h\""
  shim encoder float
} >"$work/encoder/shim.cpp"
(cd "$work/encoder" && "$cc" -std=c99 "${warnings[@]}" -O2 -c "$tests/encoder_flight.c" -I . -o flight.o &&
  "$cc" -std=c99 -O2 -c encoder.c && "$cc" flight.o encoder.o -lm -o c99 &&
  "$cxx" -std=c++20 -O2 -I "$source/runtime/include" -c shim.cpp && "$cxx" flight.o shim.o -lm -o cpp &&
  sed 's/static const IN_FLASH Scalar kWrap\[.*/static const IN_FLASH Scalar kWrap[kNr] = {0.0f, 0.0f};/' encoder.c >control.c &&
  ! cmp -s encoder.c control.c && "$cc" -std=c99 -O2 -c control.c && "$cc" flight.o control.o -lm -o control)
if "$work/encoder/c99" >"$work/encoder/c99.txt" && "$work/encoder/cpp" | diff "$work/encoder/c99.txt" -; then
  echo "ok      $(cat "$work/encoder/c99.txt")"
else
  echo "FAILED  $(cat "$work/encoder/c99.txt")" && failed=1
fi
! "$work/encoder/control" >"$work/control.txt" || { echo 'FAILED  an encoder without a wrap was not detected' && failed=1; }

# The single header: alone in an empty folder, in two translation units, with the same bits, and short. Control: one
# weight changed by half a percent.
plain=(-std=c++20 "${warnings[@]}" -fno-exceptions -fno-rtti)
single() { # FLAGS: compiles and runs it
  # shellcheck disable=SC2086
  "$cxx" "${plain[@]}" $1 -DNLO_C99_SINGLE -c "$work/shim_single.cpp" -o "$work/single.o"
  undefined=$(nm -u "$work/single.o" | grep -vE ' (mem(cpy|move|set)|__stack_chk_fail|_GLOBAL_OFFSET_TABLE_)$' || true)
  [ -z "$undefined" ] || { echo "FAILED  single $1 references $undefined" && failed=1; }
  "$cxx" "$work/main.o" "$work/single.o" "$work/other_unit.o" -o "$work/got" && "$work/got" >"$work/got.txt"
}
for entry in "${names[@]}"; do echo "#include \"${entry%:*}.h\""; done >"$work/single/other_unit.cpp"
for entry in "${names[@]}"; do echo "static nlo::single::${entry%:*}::Observer used_${entry%:*};"; done >>"$work/single/other_unit.cpp"
echo "const void* other_unit() { return &used_rig; }" | sed '1i const void* other_unit();' >>"$work/single/other_unit.cpp"
(cd "$work/single" && "$cxx" "${plain[@]}" -O1 -Wno-unused-variable -c other_unit.cpp -o "$work/other_unit.o")
for flags in -O0 "-O3 -march=native $contracted"; do
  if single "$flags" && diff "$work/want.txt" "$work/got.txt"; then echo "ok      single $flags"; else echo "FAILED  single $flags" && failed=1; fi
done
! grep -n '^ *#include "' "$work"/single/*.h || { echo 'FAILED  a single header includes another' && failed=1; }
"$export_model" rig single float rig "$work/single/rig.h" 1.005
! single -O0 || { echo 'FAILED  a wrong weight of the single header was not detected' && failed=1; }
grep -q '^rig answers' "$work/got.txt" || { echo 'FAILED  it was not the replay that detected it' && failed=1; }

# Controls: one weight changed by half a percent; a gate and a rate that are slightly wrong; fused arithmetic; a header
# with the source of another export; a call of libm.
"$export_model" rig c99 float rig "$work/rig.h" 1.005
(cd "$work" && "$cc" "${strict[@]}" -O2 -c rig.c && "$cc" main.o "${objects[@]}" -o control)
! "$work/control" >"$work/control.txt" || { echo 'FAILED  a wrong weight was not detected' && failed=1; }
grep -q '^rig answers' "$work/control.txt" || { echo 'FAILED  it was not the replay that detected it' && failed=1; }

cp "$work/gated.c" "$work/gated_good.c"
for altered in 's/(t \* 0.5f) + 0.5f/(t * 0.5f) + 0.49f/:gated answers' 's/k = 15; k >= 0/k = 1; k >= 0/:gated '; do
  sed "${altered%:*}" "$work/gated_good.c" >"$work/gated.c"
  (cd "$work" && "$cc" "${strict[@]}" -O2 -c gated.c && "$cc" main.o "${objects[@]}" -o control)
  "$work/control" | diff "$work/want.txt" - >"$work/control.txt" || true
  grep -q "^> ${altered#*:}" "$work/control.txt" || { echo "FAILED  ${altered%:*} was not detected" && failed=1; }
done
mv "$work/gated_good.c" "$work/gated.c"
(cd "$work" && "$cc" "${strict[@]}" -O2 -c gated.c)

"$export_model" rig c99 float rig "$work/rig.h"
cp "$work/rig.c" "$work/rig_good.c"
"$export_model" rig c99 float rig "$work/cpp/rig.h" 1.005
cp "$work/cpp/rig.c" "$work/rig.c"
(cd "$work" && ! "$cc" "${strict[@]}" -c rig.c 2>control.txt) || { echo 'FAILED  a mixed pair compiles' && failed=1; }
grep -q 'not of one export' "$work/control.txt" || { cat "$work/control.txt" && failed=1; }
mv "$work/rig_good.c" "$work/rig.c"
if [[ $(uname -m) == x86_64 ]] && grep -qw fma /proc/cpuinfo; then
  for source_file in "${sources[@]}"; do sed -i '/^#pragma/d' "$source_file"; done
  (cd "$work" && "$cc" -O2 -mfma -ffp-contract=fast -c "${sources[@]}" && "$cc" main.o "${objects[@]}" -o control)
  ! "$work/control" | diff -q "$work/want.txt" - >"$work/control.txt" || { echo 'FAILED  fused arithmetic was not detected' && failed=1; }
fi
echo 'float fmodf(float, float); float control(float x); float control(float x) { return fmodf(x, 2.0f); }' >"$work/control.c"
"$cc" "${strict[@]}" -O2 -c "$work/control.c" -o "$work/control.o"
[ -n "$(nm -u "$work/control.o")" ] || { echo 'FAILED  a call was not detected' && failed=1; }
# If floats are computed with more digits, the file refuses to compile, because its bits would differ.
if "$cc" -mfpmath=387 -E -x c /dev/null >/dev/null 2>&1; then
  if "$cc" -std=c99 -mfpmath=387 -c "${sources[0]}" -o "$work/x87.o" 2>"$work/x87.txt"; then
    echo 'FAILED  C99 compiles for an x87' && failed=1
  fi
  grep -q 'FLT_EVAL_METHOD must be 0' "$work/x87.txt" || { cat "$work/x87.txt" && failed=1; }
fi
exit "$failed"

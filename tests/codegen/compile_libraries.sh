#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The folders of `--target arduino` and `--target zephyr`, as far as they can be tested without the vendors' tools:
# sketches and samples compile against minimal shims, on this machine and with the cross compiler if there is one, and
# run for some simulated seconds; an older C++ gets an error that says what to do; metadata have the required form.
#   compile_libraries.sh EXPORT_MODEL SOURCE_DIR CMAKE
set -euo pipefail
export_model=$1 source=$2 cmake=$3
shims=$source/tests/codegen/shims
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
warnings=(-Wall -Wextra -Werror)
failed=0
fail() { echo "FAILED  $*" && failed=1; }

# estimates PROGRAM COUNT LINES: expects LINES lines with COUNT numbers each, and no message except the one time when
# the simulated board is too busy to sample (shims).
estimates() {
  local number='-?[0-9]+(\.[0-9]+)? '
  "$1" >"$work/printed.txt" || fail "$1 does not end well"
  [[ $(grep -cxE "($number){$2}" "$work/printed.txt") -eq $3 && $(wc -l <"$work/printed.txt") -eq $(($3 + 1)) &&
    $(grep -cx 'clamped, held, late or refused' "$work/printed.txt") -eq 1 ]] ||
    { cat "$work/printed.txt"; fail "$1 does not print $3 lines of $2 estimates and tell of one gap"; }
  echo "ok      ${1#"$work"/}: $(tail -n 1 "$work/printed.txt")"
}

# sketch LIBRARY NAME C++STANDARD OUTPUT [COMPILER FLAG...]. On this machine a sketch uses the scalar kernels of a
# microcontroller.
sketch() {
  local library=$1 name=$2 standard=$3 output=$4
  shift 4
  "$@" -std="$standard" "${warnings[@]}" -Wno-volatile -I"$library/src" -I"$shims/arduino" \
    ${kernels--DNLO_SCALAR_KERNELS} -DSKETCH="\"$library/examples/$name/$name.ino\"" "$shims/arduino/main.cpp" -o "$output"
}

cross=()
if command -v arm-none-eabi-g++ >/dev/null; then
  cross=(arm-none-eabi-g++ -mthumb -mcpu=cortex-m0plus -fno-exceptions -fno-rtti -fno-threadsafe-statics -Os -c)
fi

for entry in van_der_pol:float:2 rig:double:3 driven:float:2 pendulum:float:2; do
  IFS=: read -r name scalar states <<<"$entry"
  library=$work/arduino/$name
  mkdir -p "$work/arduino" "$work/zephyr"
  "$export_model" $name arduino $scalar $name "$library"
  sketch "$library" $name gnu++20 "$work/sketch" g++ -O1
  estimates "$work/sketch" "$states" 3
  if ((${#cross[@]})); then sketch "$library" $name gnu++20 "$work/sketch.o" "${cross[@]}"; fi

  # Exactly one error, which says what to do.
  ! kernels= sketch "$library" $name gnu++20 "$work/host" g++ 2>"$work/errors.txt" ||
    fail "$name compiles for a processor whose kernels it leaves out"
  grep -q '#error "this library is for microcontrollers' "$work/errors.txt" || fail "$name: no word of microcontrollers"
  ! sketch "$library" $name gnu++17 "$work/old" g++ 2>"$work/errors.txt" || fail "$name compiles as C++17"
  grep -q "#error \"$name.h needs C++20: compile with -std=gnu++20" "$work/errors.txt" || fail "$name: no word of C++20"

  if [[ -e $library/src/${name}_c99.h ]]; then
    gcc -std=gnu99 -O1 "${warnings[@]}" -c "$library/src/${name}_c99.c" -o "$work/c99.o"
    sketch "$library" ${name}_c99 gnu++11 "$work/sketch_c99" g++ -O1 "$work/c99.o"
    estimates "$work/sketch_c99" "$states" 3
  elif [[ $name != driven && $name != pendulum ]]; then
    fail "$name has no C99 pair"
  fi
  for key in name version author maintainer sentence paragraph category url architectures includes; do
    grep -qE "^$key=" "$library/library.properties" || fail "library.properties has no $key"
  done

  module=$work/zephyr/$name
  "$export_model" $name zephyr $scalar $name "$module"
  settings=()
  if [[ -e $module/src/${name}_c99.c ]]; then settings=("-DEXTRA_SETTINGS=CONFIG_NLO_${name^^}_C99=y"); fi
  { "$cmake" -G Ninja -S "$module/samples/$name" -B "$work/sample_$name" -DZephyr_DIR="$shims/zephyr" \
    -DEXTRA_ZEPHYR_MODULES="$module" "${settings[@]}" && "$cmake" --build "$work/sample_$name"; } >"$work/zephyr.log" 2>&1 ||
    { cat "$work/zephyr.log"; fail "the Zephyr sample of $name does not build"; continue; }
  if ((${#settings[@]})); then [[ -e $work/sample_$name/modules/libnlo_$name.a ]] || fail "$name: the C99 library is not built"; fi
  estimates "$work/sample_$name/app" "$states" 3
  awk '/^config NLO_[A-Z0-9_]+$/ || /^\t(bool ".*"|depends on [A-Z0-9_]+|imply [A-Z0-9_]+ if [A-Z0-9_]+|help)$/ || /^\t  / ||
    /^#/ || /^$/ { next } { print "Kconfig: " $0; bad = 1 } END { exit bad }' "$module/Kconfig" || fail "Kconfig of $name"
  if python3 -c 'import yaml' 2>/dev/null; then
    for file in zephyr/module.yml "samples/$name/sample.yaml"; do
      python3 -c 'import sys, yaml; yaml.safe_load(open(sys.argv[1]))' "$module/$file" || fail "$file is not YAML"
    done
  fi
done

# Control: without the runtime's headers nothing compiles, so the program above used these.
rm -r "$work/arduino/van_der_pol/src/nlo"
! sketch "$work/arduino/van_der_pol" van_der_pol gnu++20 "$work/sketch" g++ 2>/dev/null || fail 'the library does not need its own runtime'
exit "$failed"

#!/bin/bash
# SPDX-License-Identifier: MIT
# C99 exports on an ATmega328P (Arduino Uno: 32 KB of flash, 2 KB of RAM), emulated by simavr: constants stay in flash,
# the golden replay agrees, and the bits are those of this machine. Checks the table of bench/embedded/avr/README.md,
# cycles and bytes, to 5 %.
#   usage: avr.sh EXPORT_MODEL SOURCE_DIR WORK_DIR [--write bench/embedded/avr/README.md]
set -euo pipefail
export_model=$1 source=$2 work=$3 target=${5:-}
rm -rf "$work"
mkdir -p "$work"
source "$source/bench/embedded/write_table.sh"
source "$source/tests/codegen/c99/drive.sh"
failed=0
fail() { echo "FAILED  $*" >&2 && failed=1; }

shipped=$source/examples/models/van_der_pol.json
flags=(-std=gnu99 -Os -DF_CPU=16000000UL -Wall -Wextra -Werror -ffunction-sections -fdata-sections
  -Wl,--gc-sections "-I$source" "-I$work")
# build FILE... -o IMAGE
build() { avr-gcc -mmcu=$mcu "${flags[@]}" "$@" -lm; }
# run IMAGE: prints its output, without the colours and the final point that simavr adds to each line.
run() { timeout 250 simavr -m $mcu -f 16000000 "$1" 2>&1 </dev/null | tr -d '\r' | sed -E 's/\x1b\[[0-9;]*m//g; s/\.+$//'; }

# As strict as elsewhere, except for the conversions in <avr/pgmspace.h>.
strict=(-Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Wstrict-prototypes -Wmissing-prototypes)
lines=('| network | step | estimate | ms | flash [B] | RAM [B] | stack [B] |'
  '|---|---|---|---|---|---|---|')
# Some golden replays need the flash of an Arduino Mega.
for entry in "shipped_int16|$shipped|int16|atmega328p|600|the example's, int16" "shipped|$shipped|float|atmega328p|200|the example's, float" \
  'paper_int16|van_der_pol|int16|atmega2560|50|3-50x4-2 tanh, int16' 'rig_int16|rig|int16|atmega2560|600|' \
  'gated_int16|gated|int16|atmega2560|600|'; do
  IFS='|' read -r name model scalar replay_on steps title <<<"$entry"
  mcu=$replay_on
  "$export_model" "$model" c99 "$scalar" "$name" "$work/$name.h"
  "$export_model" "$model" replay-c99 "$scalar" "$name" "$work/${name}_replay.h"
  build "${strict[@]}" -c "$work/$name.c" -o "$work/$name.o"
  data=$(avr-size -A "$work/$name.o" | awk '$1 ~ /^\.(data|bss|rodata)/ { sum += $2 } END { print sum + 0 }')
  [[ $data -eq 0 ]] || fail "$name: $data bytes of its constants are in RAM"

  { printf '#define NLO_STEPS %d\n#define NLO_CALM %d\n' "$steps" $((steps / 3))
    drive_of "$name" float "$work/$name.h" | grep -v NLO_WATCHED # no room for a monitor beside a replay
    printf '#ifdef NLO_ON_BOARD\nint main(void) { board_exit(%s_drive()); }\n#else\nint main(void) { return %s_drive(); }\n#endif\n' $name $name
  } >"$work/main_$name.c"
  cc -std=c99 -O1 -I"$source" "$work/main_$name.c" "$work/$name.c" -o "$work/here_$name"
  "$work/here_$name" >"$work/want_$name.txt"
  build -DNLO_ON_BOARD "$work/main_$name.c" "$work/$name.o" "$source/toolchains/avr/board.c" -o "$work/drive_$name.elf"
  run "$work/drive_$name.elf" >"$work/said_$name.txt"
  grep -qxF "$(cat "$work/want_$name.txt")" "$work/said_$name.txt" && grep -qx 'exit status 0' "$work/said_$name.txt" ||
    { cat "$work/want_$name.txt" "$work/said_$name.txt" && fail "$name has not the bits of this machine"; }

  [[ $title ]] || continue
  mcu=atmega328p
  build -c "$work/$name.c" -o "$work/$name.o"
  count=(-DNLO_NAME="$name" -DNLO_HEADER="\"$name.h\"" "$work/$name.o")
  build "${count[@]}" "$source/bench/embedded/avr/count.c" "$source/toolchains/avr/board.c" -o "$work/count_$name.elf"
  build "${count[@]}" "$source/bench/embedded/avr/fly.c" -o "$work/fly_$name.elf"
  run "$work/count_$name.elf" >"$work/counted_$name.txt"
  grep -qx 'exit status 0' "$work/counted_$name.txt" || { cat "$work/counted_$name.txt" && fail "$name was not counted"; }
  read -r _ step _ estimate _ stack _ _ < <(grep '^step ' "$work/counted_$name.txt")
  read -r flash ram < <(avr-size "$work/fly_$name.elf" | awk 'NR == 2 { print $1 + $2, $2 + $3 }')
  ((flash <= 32256)) || fail "$name: $flash bytes of flash; the boot loader leaves 32,256"
  ((ram + stack <= 1536)) || fail "$name: $ram bytes of RAM and $stack of stack; 512 of 2,048 are for the sketch"
  lines+=("| $title | $step | $estimate | $(awk -v c=$((step + estimate)) 'BEGIN { printf "%.1f", c / 16000 }') | $flash | $ram | $stack |")
done

mcu=atmega328p
# A sketch is C++; there, too, the replay must stay in flash.
printf '#include "shipped_int16_replay.h"\nint main() { shipped_int16_observer o; shipped_int16_init(&o); return shipped_int16_first_mismatch(&o); }\n' \
  >"$work/sketch.cpp"
avr-g++ -mmcu=$mcu "${flags[@]/gnu99/gnu++11}" "$work/sketch.cpp" "$work/shipped_int16.o" -lm -o "$work/sketch.elf"
((($(avr-size "$work/sketch.elf" | awk 'NR == 2 { print $2 + $3 }') <= 64))) || fail 'the replay in C++ takes RAM'

# Controls: a constant without IN_FLASH is found in RAM, and another weight gives other bits.
sed 's/static const IN_FLASH int16_t kTanhTable/static const int16_t kTanhTable/; s/const IN_FLASH int16_t\* at/const int16_t* at/' \
  "$work/shipped_int16.c" >"$work/in_ram.c"
build -c "$work/in_ram.c" -o "$work/in_ram.o"
avr-size -A "$work/in_ram.o" | grep -qE '^\.(data|rodata).* 1026 ' || fail 'the control: a table of 1,026 bytes in RAM is not seen'
sed -E '0,/kBias1.*\{/ { /kBias1/ { n; s/-?[0-9]+/12345/ } }' "$work/shipped_int16.c" >"$work/altered.c"
build -DNLO_ON_BOARD "$work/main_shipped_int16.c" "$work/altered.c" "$source/toolchains/avr/board.c" -o "$work/altered.elf"
! run "$work/altered.elf" | grep -qxF "$(cat "$work/want_shipped_int16.txt")" || fail 'the control: another bias was not detected'

# A double of 32 bits and a dialect without address spaces are refused with an error that says what to do.
"$export_model" tiny c99 double tiny "$work/tiny.h"
! build -c "$work/tiny.c" -o "$work/tiny.o" 2>"$work/double.txt" || fail 'double compiles'
grep -q 'export with --scalar float or int16' "$work/double.txt" || fail 'double: no word of --scalar'
! build -std=c99 -c "$work/shipped_int16.c" -o "$work/c99.o" 2>"$work/c99.txt" || fail '-std=c99 compiles'
grep -q 'compile with -std=gnu99' "$work/c99.txt" || fail '-std=c99: no word of gnu99'

table=$(printf '%s\n' "${lines[@]}")
echo "$table"
begin='<!-- avr -->' end='<!-- end of avr -->'
if [[ $target ]]; then
  write_table "$begin" "$end" "$table" "$target"
else
  compare_table "$begin" "$end" "$table" "$source/bench/embedded/avr/README.md" || failed=1
fi
exit "$failed"

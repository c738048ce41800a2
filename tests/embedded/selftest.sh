#!/bin/bash
# SPDX-License-Identifier: MIT
# The program of `nlo export --target selftest` on this machine and on emulated boards: it compiles as strict C, no
# sample is wrong, the bits are equal everywhere, and it names its cycle counter. Controls: it reports a weight that is
# changed by half a percent, and fused sums, by their bits.
#   usage: selftest.sh EXPORT_MODEL SOURCE_DIR WORK_DIR
set -euo pipefail
export_model=$1 source=$2 work=$3
rm -rf "$work" && mkdir -p "$work"
cd "$work"
failed=0
fail() { echo "FAILED  $*" && failed=1; }
strict=(-std=c99 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Wstrict-prototypes -Wmissing-prototypes -Werror)

# on_board NAME: writes a main() that prints through the emulator.
on_board() {
  printf '#include "toolchains/semihosting.h"\n#include "%s_selftest.h"\n' "$1"
  printf 'static void put(char c) {\n  const char text[2] = {c, 0};\n  board_write(text);\n}\n'
  printf 'int main(void) {\n  board_exit(%s_selftest(put));\n}\n' "$1"
}
# expect WHERE NAME COUNTER FILE
expect() {
  grep -q ", 0 wrong, $(cat "$2.bits")\$" "$4" || { cat "$4" && fail "$1: $2 has wrong samples, or not the bits of this machine"; }
  grep -q "^$3" "$4" || { cat "$4" && fail "$1: no word of \"$3\""; }
  echo "ok      $1: $(tr '\n' ' ' <"$4")"
}

cortex_m() { # CORE FLAGS BOARD COUNTER NAMES
  local name
  for name in $5; do
    # shellcheck disable=SC2086
    arm-none-eabi-gcc "${strict[@]}" $2 -O2 -ffunction-sections -fdata-sections -I"$source" -I"$name" "on_board_$name.c" \
      "$name/$name.c" "$name/${name}_selftest.c" "$source/toolchains/cortex_m/startup.S" \
      "$source/toolchains/cortex_m/semihosting.c" -nostartfiles --specs=nano.specs --specs=nosys.specs \
      -L"$source/toolchains/cortex_m" -T"$3.ld" -Wl,--gc-sections -Wl,--no-warn-rwx-segments -o "$1_$name.elf"
    "$source/tests/embedded/run_on_board.sh" "$3" "$1_$name.elf" >"$1_$name.txt" || fail "$1: $name ends with an error"
    expect "$1" "$name" "$4" "$1_$name.txt"
  done
}

for entry in van_der_pol:int16 commanded:double gated:float rig:float; do
  IFS=: read -r name scalar <<<"$entry"
  "$export_model" "$name" selftest "$scalar" "$name" "$name"
  cc "${strict[@]}" -O2 "$name"/*.c -o "here_$name"
  "./here_$name" >"here_$name.txt" || fail "$name ends with an error"
  sed -n 's/.* wrong, //p' "here_$name.txt" >"$name.bits"
  expect 'this machine' "$name" 'ns, POSIX clock' "here_$name.txt"
  grep -qE '^step +[0-9]+ \([0-9]+ to [0-9]+\)$' "here_$name.txt" || fail "$name: no time of a step"
  on_board "$name" >"on_board_$name.c"
done

if command -v arm-none-eabi-gcc >/dev/null && command -v qemu-system-arm >/dev/null; then
  cortex_m m4f '-mthumb -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard' mps2-an386 'no counter here' 'gated rig'
  cortex_m m0plus '-mthumb -mcpu=cortex-m0plus -mfloat-abi=soft' microbit 'cycles, SysTick' 'van_der_pol'
fi
if command -v riscv64-unknown-elf-gcc >/dev/null && command -v qemu-system-riscv32 >/dev/null; then
  board=$source/toolchains/riscv_virt
  riscv64-unknown-elf-gcc "${strict[@]}" -march=rv32imac -mabi=ilp32 -ffreestanding -O2 -I"$source" -Igated on_board_gated.c \
    gated/gated.c gated/gated_selftest.c "$board"/{startup.S,semihosting.c,memory.c} -nostdlib -T"$board/virt.ld" \
    -Wl,--no-warn-rwx-segments -lgcc -o rv32.elf
  timeout 250 qemu-system-riscv32 -M virt -bios none -nographic -monitor none -serial null \
    -semihosting-config enable=on,target=native -kernel rv32.elf </dev/null >rv32.txt 2>&1 || fail 'riscv32 ends with an error'
  expect riscv32 gated 'cycles, mcycle' rv32.txt
fi
if command -v avr-gcc >/dev/null && command -v simavr >/dev/null; then
  avr-gcc -mmcu=atmega2560 -std=gnu99 -Os -DF_CPU=16000000UL -Wall -Wextra -Werror -ffunction-sections -fdata-sections \
    -Wl,--gc-sections -I"$source" -Ivan_der_pol on_board_van_der_pol.c van_der_pol/van_der_pol.c \
    van_der_pol/van_der_pol_selftest.c "$source/toolchains/avr/board.c" -lm -o avr.elf
  timeout 250 simavr -m atmega2560 -f 16000000 avr.elf 2>&1 </dev/null | tr -d '\r' |
    sed -E 's/\x1b\[[0-9;]*m//g; s/\.+$//' >avr.txt
  grep -qx 'exit status 0' avr.txt || fail 'avr ends with an error'
  expect avr van_der_pol 'cycles, timer 1' avr.txt
fi

# Controls.
mkdir altered
"$export_model" rig c99 float rig altered/rig.h 1.005
cp rig/{rig_replay.h,rig_selftest.*,nlo_cycles.h,main.c} altered
cc -std=c99 -O1 altered/*.c -o control
! ./control >control.txt || fail 'the control: a wrong weight ends well'
grep -qE '^sample [0-9]+ x_hat[0-9] is 0x[0-9a-f]{8}, not 0x[0-9a-f]{8}$' control.txt || { cat control.txt && fail 'the control: the wrong estimate is not told'; }
if [[ $(uname -m) == x86_64 ]] && grep -qw fma /proc/cpuinfo; then
  sed '/^#pragma/d' rig/rig.c >altered/rig.c
  cp rig/rig.h altered
  cc -std=gnu99 -O2 -mfma -ffp-contract=fast altered/*.c -o fused
  ./fused >fused.txt || fail 'fused sums are beyond the tolerance'
  ! grep -q "$(cat rig.bits)" fused.txt || fail 'the control: fused sums have the same bits'
fi
exit "$failed"

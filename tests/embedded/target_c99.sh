#!/bin/bash
# SPDX-License-Identifier: MIT
# C99 exports built with a toolchain file: strict C without warnings, no symbol that the target lacks, the golden
# replay, and the bits of this machine.
#   usage: target_c99.sh CMAKE EXPORT_MODEL SOURCE_DIR TOOLCHAIN WORK_DIR
set -euo pipefail
cmake=$1 export_model=$2 source=$3 toolchain=$4 work=$5
rm -rf "$work"
mkdir -p "$work/exports"
source "$source/tests/codegen/c99/drive.sh"

case $toolchain in
  cortex-m0plus) board=microbit floats='__aeabi_(f|cf|i2f|ui2f).*' ;;
  cortex-m4f) board=mps2-an386 ;;
  cortex-m7) board=mps2-an500 ;;
  cortex-m33) board=mps2-an505 ;;
  riscv32) floats='__((add|sub|mul|div)sf3|(eq|ne|lt|le|gt|ge)sf2|fixsfsi|floatsisf)' ;;
esac

entries=(van_der_pol:float rig:float tiny_relu:float tiny_silu:float rig_int16:int16 gated:float gated_int16:int16)
if [[ $toolchain != cortex-m0plus ]]; then entries+=(driven:float general:float watched_rig:float); fi # its flash is too small for these
for entry in "${entries[@]}"; do
  IFS=: read -r name scalar <<<"$entry"
  "$export_model" "${name%_int16}" c99 "$scalar" $name "$work/exports/$name.h"
  "$export_model" "${name%_int16}" replay-c99 "$scalar" $name "$work/exports/${name}_replay.h"
  drive_of "$name" float "$work/exports/$name.h"
done >"$work/exports/main.c"
{
  echo 'int main(void) { return 0'
  for entry in "${entries[@]}"; do echo "  + ${entry%:*}_drive()"; done
  echo '  ; }'
} >>"$work/exports/main.c"
cc -std=c99 -O1 -I"$source" "$work"/exports/*.c -o "$work/here"
"$work/here" >"$work/want.txt"

"$cmake" -S "$source/tests/embedded/c99" -B "$work/build" -G Ninja --toolchain "$source/toolchains/$toolchain.cmake" \
  -DCMAKE_BUILD_TYPE=None -DNLO_SOURCE="$source" -DNLO_EXPORTS="$work/exports" >"$work/build.log" 2>&1 &&
  "$cmake" --build "$work/build" >>"$work/build.log" 2>&1 || { cat "$work/build.log"; exit 1; }

failed=0
nm=$(sed -n 's/^CMAKE_NM:FILEPATH=//p' "$work/build/CMakeCache.txt")
# outside OBJECT: prints the symbols that the target's compiler does not provide.
outside() { "$nm" -u "$1" | awk '{ print $NF }' | grep -vxE "${floats:-none}"; }
objects=$(find "$work/build" -path '*observers_*' -name '*.o*')
[[ $(wc -w <<<"$objects") -eq $((4 * ${#entries[@]})) ]] || { echo 'FAILED  objects are missing' && failed=1; }
for object in $objects; do
  if outside "$object"; then echo "FAILED  ${object#"$work"/build/} needs the symbols above" && failed=1; fi
done
outside "$(find "$work/build" -name 'main.c.o*')" >"$work/control.txt" || { echo 'FAILED  the audit finds no call' && failed=1; }

case $toolchain in
  cortex-*) "$source/tests/embedded/run_on_board.sh" "$board" "$work/build/drive.elf" "$work/want.txt" || failed=1 ;;
  riscv32)
    timeout 250 qemu-system-riscv32 -M virt -bios none -nographic -monitor none -serial null \
      -semihosting-config enable=on,target=native -kernel "$work/build/drive" </dev/null 2>&1 |
      diff "$work/want.txt" - || failed=1 # semihosting writes to stderr
    ;;
  *) "qemu-$toolchain" "$work/build/drive" | diff "$work/want.txt" - || failed=1 ;;
esac
if ((failed == 0)); then echo "the bits of this machine on $toolchain:" && cat "$work/want.txt"; fi
exit "$failed"

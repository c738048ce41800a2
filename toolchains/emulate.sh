#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs an image on an emulated board until it ends. Its output is printed on stderr, by qemu.
#   usage: emulate.sh BOARD IMAGE [QEMU_OPTION...]
#   -icount shift=0,sleep=off lets one instruction take 1 ns of the board's time: every run is the same.
set -eu
board=$1 image=$2
shift 2
case $board in
  virt) set -- qemu-system-riscv64 -M virt -cpu rv64,v=true,vext_spec=v1.0,vlen=128 -bios none "$@" ;;
  *) set -- qemu-system-arm -M "$board" "$@" ;;
esac
exec "$@" -nographic -monitor none -serial null -semihosting-config enable=on,target=native -kernel "$image" </dev/null

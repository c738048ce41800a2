#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs an image on an emulated board, where an instruction takes 1 ns: every run is the same. With a golden file, its
# lines that match PATTERN must be what the program prints.
#   usage: run_on_board.sh BOARD IMAGE [GOLDEN PATTERN]
#   NLO_UPDATE_GOLDENS=1 makes the golden what was printed.
set -euo pipefail
board=$1 image=$2 golden=${3:-} pattern=${4:-.}

# Emulating a clock costs time that a run without a timer can save.
clock=(-icount 'shift=0,sleep=off')
if [[ -n $golden ]]; then clock=(); fi
printed=$(mktemp)
trap 'rm -f "$printed"' EXIT
status=0
timeout 250 "$(dirname "${BASH_SOURCE[0]}")/../../toolchains/emulate.sh" "$board" "$image" "${clock[@]}" >"$printed" 2>&1 || status=$?
cat "$printed"
echo "exit status $status"
if [[ -n $golden ]]; then
  if [[ -n ${NLO_UPDATE_GOLDENS:-} && $pattern == . ]]; then cp "$printed" "$golden"; fi
  diff <(grep "$pattern" "$golden") "$printed" || { echo "not what $golden says"; exit 1; }
fi
exit "$status"

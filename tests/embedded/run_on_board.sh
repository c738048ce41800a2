#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs an image on an emulated board where each instruction takes 1 ns, so that all runs are equal. With a golden file,
# its lines that match PATTERN must equal the output of the program.
#   usage: run_on_board.sh BOARD IMAGE [GOLDEN PATTERN]
#   NLO_UPDATE_GOLDENS=1 replaces the golden file by the output.
set -euo pipefail
board=$1 image=$2 golden=${3:-} pattern=${4:-.}

# Emulating a clock costs time, which a run without a timer saves.
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
  diff <(grep "$pattern" "$golden") "$printed" || { echo "the output differs from $golden"; exit 1; }
fi
exit "$status"

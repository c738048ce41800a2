#!/bin/bash
# SPDX-License-Identifier: MIT
# The most instructions of each call of an observer with the deterministic policy: the most that was seen on an emulated
# core over inputs that look for it (seen.cpp), and what the control-flow graph of the linked program allows (bound.py).
# Prints the table of README.md and checks that no bound is below what was seen, that none is above
# it by more than 2 %, and that no figure has changed by more than 5 %.
#   usage: worst_case.sh BUILDS [CORE...]                    BUILDS/CORE holds the cross build of each core
#          worst_case.sh BUILDS --write bench/embedded/worst_case/README.md     all cores
set -euo pipefail
builds=$1 target='' cores=(m4f m7 m33)
here=$(dirname "${BASH_SOURCE[0]}")
shift
if [[ ${1:-} == --write ]]; then target=$2; elif (($#)); then cores=("$@"); fi
recorded=$here/README.md
declare -A board=([m4f]=mps2-an386 [m7]=mps2-an500 [m33]=mps2-an505 [m0plus]=microbit)
declare -A title=([m4f]=M4F [m7]=M7 [m33]=M33 [m0plus]='M0, M0+')
calls=(call_step call_step_dt call_estimate)
failed=0
source "$here/../write_table.sh"

# judge WHAT SEEN BOUND LIMIT: bound / seen, which must be in [1, LIMIT].
judge() {
  ratio=$(awk -v seen="$2" -v bound="$3" 'BEGIN { printf "%.3f", bound / seen }')
  if (($3 < $2)); then echo "FAILED: $1: the bound $3 is below the $2 instructions that were seen" >&2 && return 1; fi
  awk -v ratio="$ratio" -v limit="$4" 'BEGIN { exit !(ratio <= limit) }' && return
  echo "FAILED: $1: the bound $3 is $ratio of the $2 instructions that were seen, the limit $4" >&2
  return 1
}

# see IMAGE CORE: lines "CALL INSTRUCTIONS".
see() {
  timeout 300 qemu-system-arm -M "${board[$2]}" -icount shift=0,sleep=off -nographic -monitor none -serial null \
    -semihosting-config enable=on,target=native -kernel "$1" 2>&1 </dev/null
}

lines=('| core | network | call | seen | bound | bound / seen |' '|---|---|---|---|---|---|')
for core in "${cores[@]}"; do
  for image in "$builds/$core"/bench/embedded/worst_*.elf; do
    network=$(basename "$image" .elf) && network=${network#worst_}
    declare -A seen=() bound=()
    said=$(see "$image" "$core") || { echo "$image: $said" >&2; exit 1; }
    while read -r call count; do seen[$call]=$count; done <<<"$said"
    said=$(python3 -B "$here/bound.py" "$image" "${calls[@]}") || { echo "$image: $said" >&2; exit 1; }
    while read -r call count; do bound[$call]=$count; done <<<"$said"
    for call in "${calls[@]}"; do
      judge "$core $network $call" "${seen[$call]}" "${bound[$call]}" 1.02 || failed=1
      if [[ -n $target && $core != @(m4f|m0plus) ]]; then continue; fi # as table.sh: checked, left out of the page
      name=${call#call_} && name=${name/step_dt/step by dt}
      lines+=("| ${title[$core]} | $network | $name | ${seen[$call]} | ${bound[$call]} | $ratio |")
    done
  done
  # The controls, with the last image: a bound from a wrong fact is seen, and so is a loop that waits for data.
  said=$(python3 -B "$here/bound.py" "$builds/$core/bench/embedded/worst_relu.elf" call_step_dt --doublings 1)
  if judge control "$(see "$builds/$core/bench/embedded/worst_relu.elf" "$core" | awk '$1 == "call_step_dt" { print $2 }')" \
    "${said##* }" 9 2>/dev/null; then
    echo 'FAILED: the control: a bound below what was seen is not' >&2 && failed=1
  fi
  if said=$(python3 -B "$here/bound.py" "$image" waits_for_data 2>&1) || [[ $said != *"no bound for the loop"*waits_for_data* ]]; then
    echo "FAILED: the control: a loop that waits for data has a bound: $said" >&2 && failed=1
  fi
done
table=$(printf '%s\n' "${lines[@]}")
echo "$table"
if [[ -n $target ]]; then
  write_table '<!-- worst -->' '<!-- end of worst -->' "$table" "$target"
else
  table=${table//| M7 |/| M4F |} # within 5 % of it
  table=${table//| M33 |/| M4F |}
  compare_table '<!-- worst -->' '<!-- end of worst -->' "$table" "$recorded" || failed=1
fi
exit "$failed"

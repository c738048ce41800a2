#!/bin/bash
# SPDX-License-Identifier: MIT
# The most instructions of each call of an observer with the deterministic policy: the most that was seen on an emulated
# core over inputs that look for it (seen.cpp), and what the control-flow graph of the linked program allows (bound.py).
# Prints the table of README.md and checks that no bound is below what was seen, that none is above it by more than LIMIT,
# and that no figure has changed by more than 5 %.
#   usage: worst_case.sh BUILDS [CORE[:NETWORK,...]...]      BUILDS/CORE holds the cross build of each core;
#                                                            `exported`: all of BUILDS/CORE/models
#          worst_case.sh BUILDS --write bench/embedded/worst_case/README.md     all of them
set -euo pipefail
builds=$1 target=''
here=$(dirname "${BASH_SOURCE[0]}")
structures=relu,tanh,int16_relu,int16_tanh,gated,gated_int16,prior,carried,luenberger
declare -A all=([m4f]="$structures,exported" [m7]="$structures" [m33]="$structures" [m0plus]="int16_relu,int16_tanh,relu")
cores=(m4f m7 m33 m0plus)
shift
if [[ ${1:-} == --write ]]; then target=$2; elif (($#)); then cores=("$@"); fi
recorded=$here/README.md
declare -A board=([m4f]=mps2-an386 [m7]=mps2-an500 [m33]=mps2-an505 [m0plus]=microbit)
declare -A title=([m4f]=M4F [m7]=M7 [m33]=M33 [m0plus]='M0, M0+')
# More than 1.02, and README.md says why: software floats, and what a T* in integers still has of them.
declare -A LIMIT=([m0plus relu]=2.15 [m0plus int16_relu]=1.95 [m0plus int16_tanh]=1.95)
for core in m4f m7 m33; do LIMIT[$core gated]=1.03 LIMIT[$core gated_int16]=1.18; done # of a step by dt: README.md
LIMIT[m4f failing_rig]=1.05 LIMIT[m4f watched_rig]=1.06 # small calls, whose branches exclude each other
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
  timeout 300 "$here/../../../toolchains/emulate.sh" "${board[$2]}" "$1" -icount shift=0,sleep=off 2>&1
}

lines=('| core | network | call | seen | bound | bound / seen |' '|---|---|---|---|---|---|')
for entry in "${cores[@]}"; do
  core=${entry%%:*}
  networks=${entry#*:}
  if [[ $networks == "$core" ]]; then networks=${all[$core]}; fi
  if [[ $networks == *exported* ]]; then
    networks=${networks/exported/$(cd "$builds/$core/models" && printf '%s\n' *.json | sed 's/\.json//' | paste -sd,)}
  fi
  for network in ${networks//,/ }; do
    image=$builds/$core/bench/embedded/worst_$network.elf
    said=$(cmake --build "$builds/$core" --target "worst_$network" 2>&1) || { echo "$said" >&2; exit 1; }
    declare -A bound=()
    counted=$(see "$image" "$core") || { echo "$image: $counted" >&2; exit 1; }
    said=$(cut -d' ' -f1 <<<"$counted" | xargs python3 -B "$here/bound.py" "$image") || { echo "$image: $said" >&2; exit 1; }
    while read -r call count; do bound[$call]=$count; done <<<"$said"
    while read -r call count; do
      judge "$core $network $call" "$count" "${bound[$call]}" "${LIMIT[$core $network]:-1.02}" || failed=1
      if [[ -n $target && $core != @(m4f|m0plus) ]]; then continue; fi # as table.sh: checked, left out of the page
      name=${call#call_} && name=${name/step_dt/step by dt}
      lines+=("| ${title[$core]} | ${network//_/ } | $name | $count | ${bound[$call]} | $ratio |")
    done <<<"$counted"
  done
  # The controls: a bound from a wrong fact is seen, and so is a loop that waits for data.
  image=$builds/$core/bench/embedded/worst_${networks%%,*}.elf
  counted=$(see "$image" "$core" | awk '$1 == "call_step_dt" { print $2 }')
  said=$(python3 -B "$here/bound.py" "$image" call_step_dt --doublings 0)
  if judge control "$counted" "${said##* }" 9 2>/dev/null; then
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

#!/bin/bash
# SPDX-License-Identifier: MIT
# The most instructions of each call of an observer with the deterministic policy, seen on an emulated core over the inputs
# that seen.cpp tries. Prints the table of README.md and checks that no figure has changed by more than 5 %.
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
failed=0
source "$here/../write_table.sh"

# see IMAGE CORE prints lines "CALL INSTRUCTIONS".
see() {
  timeout 300 "$here/../../../toolchains/emulate.sh" "${board[$2]}" "$1" -icount shift=0,sleep=off 2>&1
}

lines=('| core | network | call | most instructions |' '|---|---|---|---|')
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
    counted=$(see "$image" "$core") || { echo "$image: $counted" >&2; exit 1; }
    while read -r call count; do
      if [[ -n $target && $core != @(m4f|m0plus) ]]; then continue; fi  # as in table.sh: checked, but not on the page
      name=${call#call_} && name=${name/step_dt/step by dt}
      lines+=("| ${title[$core]} | ${network//_/ } | $name | $count |")
    done <<<"$counted"
  done
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

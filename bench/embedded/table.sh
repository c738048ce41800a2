#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs what count.cpp counts on every emulated core, prints the table of docs/appendix/embedded_counts.md, or README.md for
# the M55, and checks its gates and that no figure differs from the recorded one by more than 5 %.
#   usage: table.sh BUILDS [CORE...]                    BUILDS/CORE holds the cross build of each core
#          table.sh BUILDS --write docs/appendix/embedded_counts.md     all cores but the M55
#          table.sh BUILDS --write bench/embedded/README.md m55
set -euo pipefail
builds=$1 target='' cores=(m4f m7 m33 m0plus)
shift
if [[ ${1:-} == --write ]]; then target=$2 && shift 2; fi
if (($#)); then cores=("$@"); fi
network_multiply_adds=7750 # 3 x 50 + 3 x 50 x 50 + 50 x 2
gated_multiply_adds=4256    # 33 x 64 + 33 x 32, and T*: 32 x 32 + 32 x 2
gru_multiply_adds=20480     # 96 x 128 + 96 x 64, and T*: 64 x 32
prior_multiply_adds=2896    # 29 x (48 + 24 + 7), T*: 29 x 16 + 16 x 2, and 109 of the equations and the covariance
carried_multiply_adds=182   # 80 of the rotation, four vectors turned, three modes of three components, a direction
declare -A board=([m4f]=mps2-an386 [m7]=mps2-an500 [m33]=mps2-an505 [m55]=mps3-an547 [m0plus]=microbit)
declare -A title=([m4f]=M4F [m7]=M7 [m33]=M33 [m55]=M55 [m0plus]='M0, M0+')
failed=0
here=$(dirname "${BASH_SOURCE[0]}")

source "$here/stack_bound.sh"
source "$here/write_table.sh"

# gate WHAT VALUE LIMIT
gate() {
  if awk -v value="$2" -v limit="$3" 'BEGIN { exit !(value <= limit) }'; then return; fi
  echo "FAILED: $1 is $2, the limit $3" >&2
  failed=1
}

# row CORE VARIANT: sets the line of the table and checks what has a limit.
row() {
  local core=$1 variant=$2 folder=$builds/$1/bench/embedded image said instructions painted observer per flash ram bound
  local multiply_adds=$network_multiply_adds stack_limit=512 ram_limit=32
  if [[ $core == m55 ]]; then stack_limit=544; fi # registers to save for its loops
  if [[ $variant == gated* ]]; then multiply_adds=$gated_multiply_adds stack_limit=1024 ram_limit=144; fi # z and layers of 32
  # With the stack less than 2 KB.
  if [[ $variant == gru* ]]; then multiply_adds=$gru_multiply_adds stack_limit=1536 ram_limit=456; fi
  if [[ $variant == prior* ]]; then multiply_adds=$prior_multiply_adds stack_limit=1280 ram_limit=160; fi
  if [[ $variant == carried* ]]; then multiply_adds=$carried_multiply_adds ram_limit=96; fi
  image=$folder/count_$variant.elf
  said=$(timeout 100 qemu-system-arm -M "${board[$core]}" -icount shift=0,sleep=off -nographic -monitor none -serial null \
    -semihosting-config enable=on,target=native -kernel "$image" 2>&1 </dev/null) || { echo "$image: $said" >&2; exit 1; }
  read -r _ instructions _ painted _ observer <<<"$said"
  per=$(awk -v i="$instructions" -v m=$multiply_adds 'BEGIN { printf "%.2f", i / m }')
  read -r flash ram < <(arm-none-eabi-size "$folder/idle_$variant.elf" | awk 'NR == 2 { print $1 + $2, $2 + $3 }')
  bound=$(stack_bound "$folder/CMakeFiles/fly_$variant.dir/fly.cpp.ci")
  line="| ${title[$core]} | ${variant//_/ } | $instructions | $per | $flash | $ram | $((bound > painted ? bound : painted)) |"

  case $variant in
    eigen* | naive*) return ;;
  esac
  gate "$core $variant: painted stack" "$painted" $stack_limit
  gate "$core $variant: bound of the stack" "$bound" $stack_limit
  gate "$core $variant: RAM of an observer" "$observer" $ram_limit
  case $variant in
    gated_int16) gate "$core $variant: flash" "$flash" $((19 * 1024)) ;;
    gru_int16) gate "$core $variant: flash" "$flash" $((53 * 1024)) ;; # 40 KB of weights
    int16*) [[ $core == m0plus ]] || gate "$core $variant: flash" "$flash" $((22 * 1024)) ;; # 3 KB of soft floats there
    float*) gate "$core $variant: flash" "$flash" $((38 * 1024)) ;;
    gated* | prior*) gate "$core $variant: flash" "$flash" $((25 * 1024)) ;;
    gru*) gate "$core $variant: flash" "$flash" $((91 * 1024)) ;; # 80 KB of weights
    carried*) gate "$core $variant: flash" "$flash" $((12 * 1024)) ;;
  esac
  if [[ $core == m0plus ]]; then
    case $variant in
      int16*) gate "$core $variant: instructions per multiply-add" "$per" 6 ;;
      *_int16) gate "$core $variant: instructions per multiply-add" "$per" 12 ;;
    esac
    return
  fi
  case $core,$variant in # four multiply-adds an instruction
    m55,float_*) gate "$core $variant: instructions per multiply-add" "$per" 0.8 ;;
    m55,deterministic_*) gate "$core $variant: instructions per multiply-add" "$per" 1.15 ;;
    m55,int16_*) gate "$core $variant: instructions per multiply-add" "$per" 0.9 ;;
    m55,gated_float | m55,gru_float) gate "$core $variant: instructions per multiply-add" "$per" 0.95 ;;
  esac
  case $variant in
    gru_int16) gate "$core $variant: instructions per multiply-add" "$per" 1.35 ;;
    int16_relu) gate "$core $variant: instructions per multiply-add" "$per" 1.05 ;;
    int16_tanh) gate "$core $variant: instructions per multiply-add" "$per" 1.2 ;;
    *_relu) gate "$core $variant: instructions per multiply-add" "$per" 1.25 ;;
    *_tanh) gate "$core $variant: instructions per multiply-add" "$per" 1.65 ;;
    gated*) gate "$core $variant: instructions per multiply-add" "$per" 2 ;;
    gru*) gate "$core $variant: instructions per multiply-add" "$per" 1.5 ;;
  esac
}

lines=('| core | network | instructions | per multiply-add | flash [B] | RAM [B] | stack [B] |'
  '|---|---|---|---|---|---|---|')
for core in "${cores[@]}"; do
  for variant in {float,deterministic,int16}_{relu,tanh} {eigen,naive}_tanh gated_{float,deterministic,int16} gru_{float,int16} {prior,carried}_float; do
    if [[ $core == m0plus && $variant == *deterministic* ]]; then continue; fi # soft floats: the same as float
    if [[ $variant == @(eigen|naive)* && $core != m4f ]]; then continue; fi
    row "$core" "$variant"
    if [[ -n $target && $core == @(m7|m33) ]]; then continue; fi # within 0.2 % of the M4F: checked, left out of the page
    lines+=("$line")
  done
done
table=$(printf '%s\n' "${lines[@]}")
echo "$table"
if [[ -n $target ]]; then
  write_table '<!-- table -->' '<!-- end of table -->' "$table" "$target"
else
  recorded=$(mktemp)
  trap 'rm -f "$recorded"' EXIT
  cat "$here/../../docs/appendix/embedded_counts.md" "$here/README.md" >"$recorded"
  table=${table//| M7 |/| M4F |} # they take what the M4F takes
  table=${table//| M33 |/| M4F |}
  compare_table '<!-- table -->' '<!-- end of table -->' "$table" "$recorded" || failed=1
  # The control: a first number that is another.
  if compare_table '<!-- table -->' '<!-- end of table -->' "$(sed -E '3s/\| [0-9]+ \|/| 9 |/' <<<"$table")" \
    "$recorded" 2>/dev/null; then
    echo 'FAILED: the control: a changed figure is not seen' >&2 && failed=1
  fi
fi
exit "$failed"

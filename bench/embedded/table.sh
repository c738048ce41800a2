#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs the counts of count.cpp on every emulated core and prints the tables of docs/appendix/embedded_counts.md (the paper's
# network), README.md (structures, and the M55) and riscv/README.md. Checks the limits, and that no figure differs from the
# recorded one by more than 5 %.
#   usage: table.sh BUILDS [CORE...]            BUILDS/CORE is the cross build of each core
#          table.sh BUILDS --write [CORE...]    writes the pages, with all rows of m4f, m0plus, m55, rv64, rv64v in BUILDS
set -euo pipefail
builds=$1 write='' cores=(m4f m7 m33 m0plus)
shift
if [[ ${1:-} == --write ]]; then write=1 cores=(m4f m0plus m55 rv64 rv64v) && shift; fi # M7, M33: within 0.2 % of the M4F
if (($#)); then cores=("$@"); fi
# For each structure: multiply-adds of a step and an estimate; limits of the stack and of the observer [B]; limits of the
# whole program's flash in float and in int16 [KB].
structures='
network     7750  512  32 38 22  3 x 50 + 3 x 50 x 50 + 50 x 2
gated       4256 1024 144 25 19  33 x 64 + 33 x 32, and T*: 32 x 32 + 32 x 2
gru        20480 1536 456 91 53  96 x 128 + 96 x 64, and T*: 64 x 32; stack and RAM below 2 KB, 80 or 40 KB of weights
prior       2896 1280 160 25  -  29 x (48 + 24 + 7), T*: 29 x 16 + 16 x 2, and 109 of the equations and the covariance
filter      1002 1088  96  9  -  hidden_joint of tests/codegen: 934 of the equations and the covariance, T*: 17 x 4
carried      182  512  96 12  -  80 of the rotation, four vectors turned, three modes of three components, a direction
luenberger   824  544  32  8  -  four times g_hat, 2 x 50 + 50 x 2, and 6 of the linear part
general     1698  896  32 12 12  four times F, 4 x 50 + 50 x 3 and 12 of its linear path, and T*: 3 x 50 + 50 x 2
driven     15416 1344  32 25  -  four times T*, 3 x 32 + 32 x 32 + 32 x 2, T and its tangent, and 6 of g; T* again'
declare -A board=([m4f]=mps2-an386 [m7]=mps2-an500 [m33]=mps2-an505 [m55]=mps3-an547 [m0plus]=microbit [rv64]=virt [rv64v]=virt)
declare -A title=([m4f]=M4F [m7]=M7 [m33]=M33 [m55]=M55 [m0plus]='M0, M0+' [rv64]=RV64 [rv64v]='RV64, vectors')
failed=0
here=$(dirname "${BASH_SOURCE[0]}")
counts=$here/../../docs/appendix/embedded_counts.md

source "$here/stack_bound.sh"
source "$here/write_table.sh"

# gate WHAT VALUE LIMIT
gate() {
  if awk -v value="$2" -v limit="$3" 'BEGIN { exit !(value <= limit) }'; then return; fi
  echo "FAILED: $1 is $2, the limit $3" >&2
  failed=1
}

# row CORE VARIANT: sets the line of the table and checks the figures that have a limit.
row() {
  local core=$1 variant=$2 folder=$builds/$1/bench/embedded image said instructions painted observer per flash ram bound
  local size=arm-none-eabi-size structure=${variant%_*} multiply_adds stack_limit ram_limit flash_limit int16_limit
  case $variant in *_relu | *_tanh) structure=network ;; esac
  read -r _ multiply_adds stack_limit ram_limit flash_limit int16_limit _ < <(grep "^$structure " <<<"$structures")
  if [[ $variant == *int16* ]]; then flash_limit=$int16_limit; fi
  case $core,$variant in
    m0plus,* | rv64*) ;;
    *,float_tanh | *,gated_float | *,gru_float | *,prior_float | *,driven_float) # tanh from a table
      flash_limit=$((flash_limit + 4)) stack_limit=$((stack_limit + 16)) ;;
  esac
  case $core,$variant in
    m55,*_relu | m55,*_tanh) stack_limit=544 ;; # registers to save for its loops
    m0plus,int16_*) flash_limit=21 ;;
  esac
  if [[ $core == rv64* ]]; then  # pointers and saved registers have 64 bits
    size=riscv64-linux-gnu-size ram_limit=$((ram_limit + 8)) stack_limit=$((stack_limit + 128))
  fi
  image=$folder/count_$variant.elf
  said=$(timeout 100 "$here/../../toolchains/emulate.sh" "${board[$core]}" "$image" -icount shift=0,sleep=off 2>&1) ||
    { echo "$image: $said" >&2; exit 1; }
  read -r _ instructions _ painted _ observer <<<"$said"
  per=$(awk -v i="$instructions" -v m="$multiply_adds" 'BEGIN { printf "%.2f", i / m }')
  read -r flash ram < <("$size" "$folder/idle_$variant.elf" | awk 'NR == 2 { print $1 + $2, $2 + $3 }')
  bound=$(stack_bound "$folder/CMakeFiles/fly_$variant.dir/fly.cpp.ci")
  line="| ${title[$core]} | ${variant//_/ } | $instructions | $per | $flash | $ram | $((bound > painted ? bound : painted)) |"

  case $variant in
    eigen* | naive*) return ;;
  esac
  gate "$core $variant: painted stack" "$painted" "$stack_limit"
  gate "$core $variant: bound of the stack" "$bound" "$stack_limit"
  gate "$core $variant: RAM of an observer" "$observer" "$ram_limit"
  gate "$core $variant: flash" "$flash" $((flash_limit * 1024))
  if [[ $core == m0plus ]]; then
    case $variant in
      int16*) gate "$core $variant: instructions per multiply-add" "$per" 5 ;;
      general_int16) ;; # F stays in float
      *_int16) gate "$core $variant: instructions per multiply-add" "$per" 12 ;;
    esac
    return
  fi
  case $core,$variant in  # four multiply-adds in an instruction
    m55,float_*) gate "$core $variant: instructions per multiply-add" "$per" 0.8 ;;
    m55,deterministic_*) gate "$core $variant: instructions per multiply-add" "$per" 1.15 ;;
    m55,int16_*) gate "$core $variant: instructions per multiply-add" "$per" 0.9 ;;
    m55,gated_float | m55,gru_float) gate "$core $variant: instructions per multiply-add" "$per" 0.95 ;;
    rv64v,float_*) gate "$core $variant: instructions per multiply-add" "$per" 0.35 ;; # 32 multiply-adds in an instruction
    rv64v,deterministic_*) gate "$core $variant: instructions per multiply-add" "$per" 0.4 ;;
    rv64v,int16_*) gate "$core $variant: instructions per multiply-add" "$per" 0.35 ;;
    rv64,*) return ;;  # no limit: only for comparison
  esac
  case $variant in
    gru_int16) gate "$core $variant: instructions per multiply-add" "$per" 1.35 ;;
    int16_relu) gate "$core $variant: instructions per multiply-add" "$per" 1.05 ;;
    int16_tanh) gate "$core $variant: instructions per multiply-add" "$per" 1.2 ;;
    *_relu) gate "$core $variant: instructions per multiply-add" "$per" 1.25 ;;
    float_tanh | gated_float) gate "$core $variant: instructions per multiply-add" "$per" 1.5 ;;
    *_tanh) gate "$core $variant: instructions per multiply-add" "$per" 1.65 ;;
    gated*) gate "$core $variant: instructions per multiply-add" "$per" 2 ;;
    gru_float) gate "$core $variant: instructions per multiply-add" "$per" 1.35 ;;
    gru_deterministic) gate "$core $variant: instructions per multiply-add" "$per" 1.6 ;;
  esac
}

# page_of CORE VARIANT prints the path of the page with the row of this core and variant.
page_of() {
  case $1,$2 in
    rv64*) echo "$here/riscv/README.md" ;;
    m55,* | *_float | *_deterministic | *_int16) echo "$here/README.md" ;;
    *) echo "$counts" ;;
  esac
}

head='| core | network | instructions | per multiply-add | flash [B] | RAM [B] | stack [B] |
|---|---|---|---|---|---|---|'
declare -A tables=()
for core in "${cores[@]}"; do
  for variant in {float,deterministic,int16}_{relu,tanh} {eigen,naive}_tanh {gated,gru}_{float,deterministic,int16} \
    {prior,filter,carried,luenberger,driven}_{float,deterministic} general_{float,deterministic,int16}; do
    if [[ $variant == @(eigen|naive)* && $core != m4f ]]; then continue; fi
    row "$core" "$variant"
    page=$(page_of "$core" "$variant")
    tables[$page]=${tables[$page]:-$head}$'\n'$line
  done
done
for page in "${!tables[@]}"; do
  table=${tables[$page]}
  echo "$table"
  if [[ -n $write ]]; then
    write_table '<!-- table -->' '<!-- end of table -->' "$table" "$page"
    continue
  fi
  table=${table//| M7 |/| M4F |}  # these cores take as many instructions as the M4F
  table=${table//| M33 |/| M4F |}
  compare_table '<!-- table -->' '<!-- end of table -->' "$table" "$page" || failed=1
  # The control: the comparison must fail if the first number is different.
  if compare_table '<!-- table -->' '<!-- end of table -->' "$(sed -E '3s/\| [0-9]+ \|/| 9 |/' <<<"$table")" \
    "$page" 2>/dev/null; then
    echo 'FAILED: the control: a changed figure is not seen' >&2 && failed=1
  fi
done
exit "$failed"

#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# nlo replay of flights that a firmware in C99 has logged: each structure that C99 has, in float, double and int16,
# replays with the same bits, and the first difference of an edited log is found.
#   replay.sh NLO EXPORT_MODEL SOURCE_DIR C_COMPILER [all]
set -euo pipefail
nlo=$1 export_model=$2 source=$3 cc=$4
examples='rig commanded failing computed gated carried prior general pendulum driven'
if [[ ${5:-} == all ]]; then examples=$("$export_model"); fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
failed=0
fail() { echo "FAILED  $*" && failed=1; }

# names KIND SUFFIX: the channels of the header, each followed by SUFFIX.
names() { sed -n "s/^enum { \(${name}_$1_.*\) };/\1/p" "$name.h" | sed "s/${name}_$1_//g; s/, */\n/g" | sed "s/\$/$2/"; }
# fly EXAMPLE SCALAR [FORMAT]: EXAMPLE.json and EXAMPLE.csv
fly() {
  name=$1
  "$export_model" "$1" c99 "$2" "$1" "$1.h"
  "$export_model" "$1" replay-c99 "$2" "$1" "$1_replay.h"
  "$export_model" "$1" model "$2" "$1" "$1.json"
  local scalar=float format=%.9g inputs
  if [[ $2 == double ]]; then scalar=double format=%.17g; fi
  inputs=$(names input "" | wc -l)
  {
    printf '#include "%s_replay.h"\n#define NLO_NAME %s\n#define NLO_SCALAR %s\n' "$1" "$1" "$scalar"
    printf '#define NLO_HEADING "%s"\n#define NLO_FORMAT "%s"\n' \
      "$({ names output "" && names input "" && echo dt && names state _hat && printf 'status\nin_domain\n'; } | paste -sd,)" "${3:-$format}"
    if ((inputs > 0)); then
      printf '#define NLO_INPUTS %d\n#define NLO_AND_U(sample) , (sample)->u\n' "$inputs"
    else
      printf '#define NLO_AND_U(sample)\n'
    fi
    echo "#include \"$source/tests/replay/fly.c\""
  } >"fly_$1.c"
  "$cc" -std=c99 -O0 -Wall -Wextra -Werror -I. "fly_$1.c" "$1.c" -o "fly_$1"
  "./fly_$1" >"$1.csv"
}
# same ARGUMENTS: expects that the flight is reproduced.
same() {
  "$nlo" replay "$@" >said.txt 2>&1 && grep -q 'the same' said.txt || { cat said.txt && fail "replay $*"; }
}
# differs WORDS ARGUMENTS: expects a difference, whose place the pattern WORDS describes.
differs() {
  local words=$1 status=0
  shift
  "$nlo" replay "$@" >said.txt 2>&1 || status=$?
  if ((status == 1)) && grep -qE "$words" said.txt; then echo "ok      $(grep -oE "$words" said.txt | head -1)"; else
    cat said.txt && fail "exit $status without \"$words\": replay $*"
  fi
}
# refused WORDS ARGUMENTS: expects an error that matches the pattern WORDS.
refused() {
  local words=$1 status=0
  shift
  "$nlo" replay "$@" >said.txt 2>&1 || status=$?
  ((status == 2)) && grep -qE "$words" said.txt || { cat said.txt && fail "exit $status without \"$words\": replay $*"; }
}

flown=0
for example in $examples; do
  "$export_model" "$example" c99 float "$example" "$example.h" 2>refused.txt || { grep -q 'target c99 writes' refused.txt && continue; }
  fly "$example" float
  same "$example.json" "$example.csv"
  grep -q 'bit for bit' said.txt || fail "$example is not said to be the same bit for bit"
  flown=$((flown + 1))
done
echo "ok      $flown structures and shapes, bit for bit"
((flown >= 7)) || fail "only $flown examples flew"
for entry in rig:double van_der_pol:int16 prior:double gated:int16; do
  fly "${entry%:*}" "${entry#*:}"
  same "${entry%:*}.json" "${entry%:*}.csv" --scalar "${entry#*:}"
done

# Edited logs. van_der_pol reads y and estimates x1, x2; a row: y,dt,x1_hat,x2_hat,status,in_domain.
fly van_der_pol float
model=van_der_pol.json log=van_der_pol.csv
head -2 "$log"
edit() { awk -F, -v OFS=, "$1" "$log" >edited.csv; }
regular=$(awk -F, 'NR > 90 && $2 == "" && $5 == 0 && ++n == 30 { print NR; exit }' "$log") # a row among steps of one period

edit "NR == $regular { \$3 = sprintf(\"%.9g\", \$3 * (1 + 3e-7)) } 1"
differs "edited.csv:$regular: row $((regular - 1)), .* x1_hat was .*, replayed .*: the difference is [0-9]+ units in the last place; 1 of" "$model" edited.csv
edit "NR == $regular { \$5 = 2 } 1"
differs 'status was HELD, replayed OK' "$model" edited.csv
edit "NR == $regular { \$6 = 1 - \$6 } 1"
differs 'in_domain was ., replayed .' "$model" edited.csv
edit "NR != $regular"
differs "edited.csv:$regular: row $((regular - 1)), .* rows differ" "$model" edited.csv
edit "NR == $regular { \$1 = \$1 + 0.5 } 1"
differs "edited.csv:($regular|$((regular + 1))): row " "$model" edited.csv
awk -F, -v OFS=, 'NR == 1 { print "time", $0; next } { print "12:30:00", $0 }' "$log" >edited.csv
same "$model" edited.csv
# Numbers with six digits: estimates are compared at the precision of the log, but rounded readings differ from those
# flown.
edit 'NR > 1 { $3 = sprintf("%.6g", $3); $4 = sprintf("%.6g", $4) } 1'
same "$model" edited.csv
grep -q 'compared with the digits of the log' said.txt || fail 'six digits of an estimate: no word of them'
edit 'NR > 1 && $1 !~ /nan/ { $1 = sprintf("%.5f", $1) } 1'
differs 'edited.csv:[0-9]+: row' "$model" edited.csv
edit "NR == $regular { \$3 = \$3 + 0.00001 } NR > 1 { \$3 = sprintf(\"%.6f\", \$3) } 1"
differs "edited.csv:$regular:" "$model" edited.csv
python3 - "$log" >edited.csv <<'END'
import struct, sys
for line in open(sys.argv[1]):
    cells = line.rstrip().split(",")
    print(",".join(c if i > 3 or not c or c[0].isalpha() else "0x%08x" % struct.unpack("<I", struct.pack("<f", float(c)))
                   for i, c in enumerate(cells)))
END
same "$model" edited.csv
# Another scalar type and another model must differ.
for scalar in double int16; do
  fly van_der_pol $scalar
  differs 'van_der_pol.csv:[0-9]+: row' "$model" "$log"
done
fly van_der_pol float
"$export_model" van_der_pol model float van_der_pol other.json 1.5
differs 'van_der_pol.csv:[0-9]+: row' other.json "$log"

# Input that cannot be replayed must be refused.
refused 'no column "y"' "$model" <(sed 's/^y,/z,/' "$log")
sed '1s/x1_hat,x2_hat/a,b/' "$log" >edited.csv
refused 'log the results of estimate\(\), or name the columns' "$model" edited.csv
same "$model" edited.csv --column x1_hat=a --column x2_hat=b
refused 'expected NAME=HEADING' "$model" "$log" --column x1_hat
refused 'could not be started.*name yours with --compiler' "$model" "$log" --compiler /no/such/cc
refused 'only c99 .* can be replayed' "$model" "$log" --target arduino
same "$model" "$log" -o again.csv
head -1 again.csv | grep -qx 'x1_hat,x2_hat,status,in_domain' || fail 'the replayed estimates have another heading'
exit "$failed"

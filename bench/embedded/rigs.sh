#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs the observers of docs/rigs.md on an emulated Cortex-M4F over their whole test logs, and compares their estimates with
# those of `nlo evaluate`. Prints the table of docs/appendix/embedded_counts.md; fails if one does not agree.
#   usage: rigs.sh NLO DATA WORK [--write docs/appendix/embedded_counts.md]
#   DATA  has the folders qube, double_pendulum, battery and car (examples/rigs)
#   WORK  has NAME/model.json, written by `nlo train NAME -o WORK/NAME`; missing models are trained
set -eu
source=$(cd "$(dirname "$0")/../.." && pwd)
nlo=$1 data=$2 target=''
mkdir -p "$3" && work=$(cd "$3" && pwd)
build=$work/cortex-m4f
if [ "${4:-}" = --write ]; then target=$5; fi
. "$source/bench/embedded/fly_logs.sh"
. "$source/bench/embedded/stack_bound.sh"
. "$source/bench/embedded/write_table.sh"

rigs='qube qube example_csv_fin8.csv
qube_noisy qube example_csv_fin8.csv
qube_25hz qube example_csv_fin8.csv
qube_arm qube example_csv_fin8.csv
qube_prior qube example_csv_fin8.csv
double_pendulum double_pendulum trajectory_03.csv
double_pendulum_joint1 double_pendulum trajectory_03.csv
double_pendulum_prior double_pendulum trajectory_03.csv
double_pendulum_joint1_prior double_pendulum trajectory_03.csv
battery battery *degC_Mixed7.csv
car car rubber_17.csv free_02.csv'

set -f # patterns are for nlo
mkdir -p "$work/models" "$work/flights"
set --
while read -r name folder logs; do
  [ -f "$work/$name/model.json" ] ||
    "$nlo" train "$name" --data "$data/$folder" -o "$work/$name" -q >"$work/$name.log" 2>&1 || { cat "$work/$name.log" >&2; exit 1; }
  cp "$work/$name/model.json" "$work/models/$name.json"
  set -- "$@" "$work/models/$name.json"
done <<END
$rigs
END
build_observers cmake "$(cd "$(dirname "$nlo")" && pwd)/$(basename "$nlo")" "$@"

# rig NAME FOLDER LOG...: prints the row of a rig; fails if a run does not agree.
rig() {
  name=$1 folder=$2
  shift 2
  for log; do
    set -- "$@" "$data/$folder/$log"
    shift
  done
  rm -rf "$work/flights/$name" && mkdir "$work/flights/$name"
  "$nlo" evaluate "$work/models/$name.json" --data "$@" --estimates "$work/flights/$name/log.csv" \
    >"$work/flights/$name.log" 2>&1 || { cat "$work/flights/$name.log" >&2; exit 1; }
  set +f
  flown=$(for csv in "$work/flights/$name"/*.csv; do fly "$name" "$csv" || exit 1; done)
  set -f
  echo "$flown" >"$work/flights/$name.txt"
  while read -r samples ok domain _ _ _ _ apart; do
    agrees "$samples" "$domain" "$apart" ||
      { echo "FAILED $name: $samples samples, $ok ok, in_domain() agrees at $domain, estimates $apart e-9 apart" >&2; failed=1; }
  done <"$work/flights/$name.txt"
  size=$(arm-none-eabi-size "$build/bench/embedded/idle_$name.elf" | awk 'NR == 2 { print $1 + $2 " | " $2 + $3 }')
  stack=$(stack_bound "$build/bench/embedded/CMakeFiles/exported_$name.dir/fly_exported.cpp.ci")
  macs=$(awk '/^\/\/ .* multiply-adds/ { gsub(",", ""); sum += $3 } END { print sum }' \
    "$build/bench/embedded/nlo_models/exported_$name/$name.h")
  echo "$flown" | awk -v name="$name" -v size="$size" -v stack="$stack" -v macs="$macs" '
    { samples += $1; sum += $1 * $4; if ($5 > most) most = $5; period = $6; observer = $7; if ($8 > apart) apart = $8 }
    END {
      printf "| `%s` | %d | %.1e | %d | %.0f | %d | %d | %s | %d | %d |\n", name, samples, apart * 1e-9, macs,
        sum / samples, most, period, size, observer, stack
    }'
}

failed=0
table='| observer | samples flown | largest difference | multiply-adds | instructions, mean | most | at the sample period | flash [B] | RAM [B] | observer [B] | stack, bound [B] |
|---|---|---|---|---|---|---|---|---|---|---|'
while read -r name folder logs; do
  # shellcheck disable=SC2086 # several logs
  rig "$name" "$folder" $logs >"$work/row.txt"
  table=$(printf '%s\n%s' "$table" "$(cat "$work/row.txt")")
done <<END
$rigs
END
echo "$table"
if [ -n "$target" ]; then write_table '<!-- flights -->' '<!-- end of flights -->' "$table" "$target"; fi
exit "$failed"

#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs each fuzz target for its share of MINUTES, as many at a time as there are cores, from its initial inputs and
# those that earlier runs have found (BUILD/tests/fuzz/corpus). Prints a line for each: executions, edges reached in the
# program, and the file of an input that crashed, hung or leaked. The exit code is 1 if there is one.
#   run.sh BUILD MINUTES [TARGET...]   TARGET: model, experiment, ... all of them by default
set -euo pipefail
folder=$1/tests/fuzz minutes=$2
shift 2
targets=("$@")
if (($# == 0)); then for program in "$folder"/fuzz_*; do targets+=("${program##*/fuzz_}"); done; fi
jobs=$(nproc)
((jobs < ${#targets[@]})) || jobs=${#targets[@]}
share=$(awk "BEGIN {print int(60 * $minutes * $jobs / ${#targets[@]} + 1)}")
mkdir -p "$folder/corpus" "$folder/found"
if [[ -w /dev/shm ]]; then export TMPDIR=/dev/shm; fi # what a target writes it syncs
echo "${#targets[@]} targets, $share s each, $jobs at a time; crash inputs go to $folder/found"

fuzz() {
  local folder=$1 share=$2 name=$3 outcome=ok
  mkdir -p "$folder/corpus/$name"
  "$folder/fuzz_$name" -max_total_time="$share" -timeout=20 -rss_limit_mb=2048 -max_len=65536 -print_final_stats=1 \
    -artifact_prefix="$folder/found/$name-" -seed_inputs="@$folder/$name.seeds" "$folder/corpus/$name" \
    >"$folder/$name.log" 2>&1 || outcome=FAILED
  awk -v name="$name" -v outcome="$outcome" '
    /cov: / {for (i = 1; i < NF; ++i) if ($i == "cov:") edges = $(i + 1)}
    /number_of_executed_units/ {executions = $2}
    /average_exec_per_sec/ {rate = $2}
    /Test unit written to/ {written = $NF}
    END {printf "%-6s  %-15s %12d executions, %6d a second, %6d edges %s\n", outcome, name, executions, rate, edges, written}
  ' "$folder/$name.log"
  [[ $outcome == ok ]] || { grep -m 1 -A 12 -E 'ERROR: |runtime error|property violated: ' "$folder/$name.log" || tail -n 5 "$folder/$name.log"; }
  [[ $outcome == ok ]]
}
export -f fuzz
printf '%s\n' "${targets[@]}" | xargs -P "$jobs" -I {} bash -c 'fuzz "$@"' _ "$folder" "$share" {}

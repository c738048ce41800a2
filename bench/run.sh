#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs the benchmarks several times and writes the medians of their ratios as one file for this machine.
#   usage: bench/run.sh [-n RUNS] [-b BUILD_DIR] [-o FILE]
#     -n  number of runs of each benchmark; the benchmarks run in turn (5)
#     -b  folder of a Release build with -DNLO_BENCH=ON (build/release)
#     -o  file of the results (bench/results/CPU.json)
# Use a quiet machine, because other programs slow down some runs and not others.
set -eu
cd "$(dirname "$0")/.."
runs=5 build=build/release out=
while getopts n:b:o: option; do
  case $option in
    n) runs=$OPTARG ;;
    b) build=$OPTARG ;;
    o) out=$OPTARG ;;
    *) sed -n 's/^# \{0,3\}//; 3,8p' "$0" >&2; exit 2 ;;
  esac
done
shift $((OPTIND - 1))
case $runs in '' | *[!0-9]* | 0) echo "run.sh: -n wants a number of runs, not \"$runs\"" >&2; exit 2 ;; esac
[ $# -eq 0 ] || { echo "run.sh: does not know \"$*\"" >&2; exit 2; }
if [ ! -x "$build/bench/step_latency_portable_o2" ] || [ ! -x "$build/bench/compare" ]; then
  echo "run.sh: no benchmarks in $build; cmake --preset release -DNLO_BENCH=ON && cmake --build build/release --target benchmarks" >&2
  exit 2
fi
if [ -z "$out" ]; then
  cpu=$(awk -F': *' '/^model name/ {name = $2} /^cpu family/ {family = $2} /^model[\t ]*:/ {model = $2}
    END {print name == "" ? "cpu" : name " " family " " model}' /proc/cpuinfo)
  out=bench/results/$(printf '%s' "$cpu" | tr 'A-Z' 'a-z' | tr -cs 'a-z0-9\n' '-' | sed 's/^-//; s/-$//').json
fi
mkdir -p "$(dirname "$out")"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=
run=1
while [ "$run" -le "$runs" ]; do
  for bench in step_latency step_latency_portable step_latency_portable_o2 training_epoch rt_loop; do
    case " $failed " in *" $bench "*) continue ;; esac
    options=
    if [ "$bench" = rt_loop ]; then options="--seconds 5 --plot $work/rt_loop.svg"; fi
    echo "run $run of $runs: $bench" >&2
    # shellcheck disable=SC2086
    if ! "$build/bench/$bench" $options --json "$work/$bench.$run.json" >"$work/said.txt" 2>&1; then
      tail -n 5 "$work/said.txt" >&2
      failed="$failed $bench"
    fi
  done
  run=$((run + 1))
done
"$build/bench/compare" --collect "$out" "$work"/*.json
echo "$out"
[ -z "$failed" ] || { echo "run.sh: failed and left out:$failed" >&2; exit 1; }

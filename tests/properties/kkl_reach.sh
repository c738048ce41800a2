#!/bin/sh
# SPDX-License-Identifier: MIT
# What a step and an estimate of a KKL observer reach, to be read by whoever audits them: at most 14 headers, the texts that
# are read once per instruction set beside them, and 2,150 lines in all; nothing of batches, gates, error heads,
# derivatives, saturation, failing sensors, half weights, int16, the monitor, delays and dispatch.
#   usage: kkl_reach.sh COMPILER SOURCE_DIR EIGEN_INCLUDE_DIR WORK_DIR
set -eu
compiler=$1 source=$2 work=$4
mkdir -p "$work"
cd "$source" # paths below are relative: the folder of a checkout may be called nlo, or have spaces in its name
others='batch|acting_inputs|lane_sum|gate|error_head|jvp|tangent|saturation|sensor_failures|weight|int16|quantised|monitor|delay_line|dispatch|cortex|explicit_rk|exponential_rk'

# reach FLAGS MORE_HEADERS...: how many headers and lines, and what is too much of them
reach() {
  flags=$1 && shift
  {
    for header in tiny.h "$@"; do echo "#include <$header>"; done
    echo 'int main() { nlo::tiny::Observer o{nlo::tiny::kModel}; return o.step(1.0F) == nlo::StepStatus::kOk && o.estimate()[0] > 0; }'
  } >"$work/flies.cpp"
  # shellcheck disable=SC2086
  "$compiler" -std=c++20 $flags -Iruntime/include -Itests/golden -MM "$work/flies.cpp" |
    tr ' \\' '\n\n' | grep '^runtime/include/nlo/' >"$work/reached.txt"
  headers=$(grep -c '\.h$' "$work/reached.txt") texts=$(grep -c '\.inc$' "$work/reached.txt")
  lines=$(xargs cat <"$work/reached.txt" | wc -l)
  strangers=$(grep -E "/[a-z_]*($others)[a-z_0-9]*\.(h|inc)$" "$work/reached.txt" || true)
  echo "$headers headers, $texts texts, $lines lines$flags ${strangers:+and $strangers}"
  [ "$headers" -le "$most_headers" ] && [ "$texts" -le 5 ] && [ "$lines" -le 2150 ] && [ -z "$strangers" ]
}

failed=0
most_headers=14
reach '' || { cat "$work/reached.txt" && echo 'FAILED   a KKL observer reaches too much' && failed=1; }
most_headers=16 # two small ones instead of the vectors' text
reach ' -DNLO_SCALAR_KERNELS' || { cat "$work/reached.txt" && echo 'FAILED   without vectors, too' && failed=1; }
most_headers=99
for header in nlo/kkl_batch.h nlo/gated_observer.h nlo/error_head.h nlo/monitor.h nlo/delay_line.h; do
  ! reach '' $header >"$work/control.txt" || { echo "FAILED   $header went unseen" && failed=1; }
done
exit "$failed"

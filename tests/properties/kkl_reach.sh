#!/bin/sh
# SPDX-License-Identifier: MIT
# Lists the headers that step and estimate of a KKL observer include, for an audit of only these. They must not include
# batches, gates, error heads, derivatives, saturation, half weights, int16, the monitor, delays or dispatch.
#   usage: kkl_reach.sh COMPILER SOURCE_DIR EIGEN_INCLUDE_DIR WORK_DIR
set -eu
compiler=$1 source=$2 work=$4
mkdir -p "$work"
cd "$source" # relative paths, because the folder of a checkout may be called nlo or contain spaces
others='batch|lane_sum|gate|error_head|jvp|tangent|saturation|weight|int16|quantised|monitor|delay_line|dispatch|cortex|explicit_rk|exponential_rk'

# reach FLAGS MORE_HEADERS...: prints the number of headers; fails if one of them is not needed
reach() {
  flags=$1 && shift
  {
    for header in tiny.h "$@"; do echo "#include <$header>"; done
    echo 'int main() { nlo::tiny::Observer o{nlo::tiny::kModel}; return o.step(1.0F) == nlo::StepStatus::kOk && o.estimate()[0] > 0; }'
  } >"$work/flies.cpp"
  # shellcheck disable=SC2086
  "$compiler" -std=c++20 $flags -Iruntime/include -Itests/golden -MM "$work/flies.cpp" |
    tr ' \\' '\n\n' | grep '^runtime/include/nlo/' >"$work/reached.txt"
  strangers=$(grep -E "/[a-z_]*($others)[a-z_0-9]*\.(h|inc)$" "$work/reached.txt" || true)
  echo "$(grep -c '' "$work/reached.txt") files$flags ${strangers:+and $strangers}"
  grep -q '/kkl_observer.h$' "$work/reached.txt" && [ -z "$strangers" ]
}

failed=0
reach '' || { cat "$work/reached.txt" && echo 'FAILED   a KKL observer includes too many headers' && failed=1; }
reach ' -DNLO_SCALAR_KERNELS' || { cat "$work/reached.txt" && echo 'FAILED   too many headers without vectors' && failed=1; }
for header in nlo/kkl_batch.h nlo/gated_observer.h nlo/error_head.h nlo/monitor.h nlo/delay_line.h; do
  ! reach '' $header >"$work/control.txt" || { echo "FAILED   $header was not detected" && failed=1; }
done
exit "$failed"

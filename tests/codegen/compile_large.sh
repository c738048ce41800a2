#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Large networks compile in an acceptable time and agree with their equations in each layout of their layers.
#   compile_large.sh EXPORT_MODEL INCLUDE COMPILER
set -euo pipefail
export_model=$1 include=$2 compiler=$3
longest_s=30 # 3x256 takes about 3 s on an idle machine
command -v "$compiler" >/dev/null || { echo "SKIPPED: no $compiler here"; exit 77; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
strict=(-std=c++20 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror -I "$include" -I "$work")

# name:example:scalar:PanelDense layers:Dense layers:factor on a weight
for entry in large:large:float:2:2:1 mixed:mixed:float:2:2:1 mixed_fp16:mixed:float,fp16:2:2:1 altered:mixed:float:2:2:1.05; do
  IFS=: read -r name example scalar panels rows factor <<<"$entry"
  "$export_model" $example cpp $scalar $name "$work/$name.h" $factor
  "$export_model" $example replay $scalar $name "$work/${name}_replay.h"
  [ "$(grep -c 'constexpr PanelDense<' "$work/$name.h") $(grep -c 'constexpr Dense<' "$work/$name.h")" = "$panels $rows" ] ||
    { echo "$name.h does not have $panels PanelDense and $rows Dense"; exit 1; }
  cat >"$work/main.cpp" <<END
#include "$name.h"
#include "${name}_replay.h"
int main() {
  static nlo::$name::Observer observer{nlo::$name::kModel};
  return nlo::$name::replay::first_mismatch(observer) == -1 ? 0 : 3;
}
END
  for layout in vectors scalar; do # in memory layout, and rearranged for a target without vectors
    flags=()
    [ "$layout" = vectors ] || flags=(-DNLO_SCALAR_KERNELS)
    [ "$layout $compiler" != "scalar clang++" ] || flags+=(-fconstexpr-steps=100000000) # docs/appendix/performance.md
    [ "$layout $name" != "scalar large" ] || continue
    timeout "$longest_s" "$compiler" "${strict[@]}" "${flags[@]}" -O2 "$work/main.cpp" -o "$work/main" ||
      { echo "$name ($layout): does not compile within $longest_s s"; exit 1; }
    status=0
    "$work/main" || status=$?
    want=0
    [ "$factor" = 1 ] || want=3 # the control
    [ "$status" -eq "$want" ] || { echo "$name ($layout): exit $status instead of $want"; exit 1; }
  done
done
echo "large networks compile by $compiler and agree with their models; an altered one does not"

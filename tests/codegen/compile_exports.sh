#!/usr/bin/env bash
# Compiles the exports of all example models as a user does, alone and together, with strict warnings, compares them
# with the golden samples, and checks that a wrong weight is detected.
#   compile_exports.sh EXPORT_MODEL INCLUDE EIGEN COMPILER
set -euo pipefail
export_model=$1 include=$2 eigen=$3 compiler=$4
command -v "$compiler" >/dev/null || { echo "SKIPPED: no $compiler here"; exit 77; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
strict=(-std=c++20 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror
        -I "$include" -isystem "$eigen" -I "$work")

# name:example:scalar
exports=()
for name in rig van_der_pol pendulum general driven commanded commanded_general gated failing two_rates clocked fallback computed saturating rig_error gated_error carried prior prior_functions filter filter_functions; do exports+=("${name}_double:$name:double"); done
for name in $("$export_model"); do exports+=("$name:$name:float"); done
for name in rig van_der_pol tiny tiny_relu tiny_tanh linear tiny_rk4 commanded failing two_rates clocked clocked_rig fallback computed gated commanded_gated saturating_rig rig_error; do exports+=("${name}_int16:$name:int16"); done
for name in rig van_der_pol tiny_relu pendulum driven rig_error; do exports+=("${name}_bf16:$name:float,bf16"); done
for name in van_der_pol general; do exports+=("${name}_fp16:$name:float,fp16"); done
coarse=(van_der_pol_coarse rig_coarse general_coarse driven_coarse) # tanh within 5e-5
for name in "${coarse[@]}"; do exports+=("$name:${name%_coarse}:float,,100"); done
exports+=("tiny_tanh_coarse:tiny_tanh:float,bf16,100")
deterministic=(commanded commanded_int16 computed failing failing_rig failing_int16 two_rates two_rates_int16 clocked clocked_int16 clocked_rig fallback fallback_int16 slow_angle saturating saturating_rig saturating_rig_int16 rig_int16 rig_bf16 van_der_pol_fp16 van_der_pol_coarse rig_error saturating_rig_error failing_error)

{
  for entry in "${exports[@]}"; do
    IFS=: read -r name example scalar <<<"$entry"
    "$export_model" "$example" cpp "$scalar" "$name" "$work/$name.h"
    "$export_model" "$example" replay "$scalar" "$name" "$work/${name}_replay.h"
    echo "#include \"$name.h\""
    echo "#include \"${name}_replay.h\""
  done
  echo "#include <cstdio>"
  for entry in "${exports[@]}"; do
    name=${entry%%:*}
    echo "constinit static nlo::$name::Observer observer_of_$name{nlo::$name::kModel};"
  done
  # Weights and tanh do not depend on the policy.
  for name in "${deterministic[@]}"; do
    echo "constinit static nlo::KklObserver<nlo::$name::Model, nlo::Arithmetic::kDeterministic>"
    echo "    deterministic_$name{nlo::$name::kModel};"
  done
  echo "int main() {"
  for entry in "${exports[@]}"; do
    name=${entry%%:*}
    echo "  std::printf(\"$name %d\\n\", nlo::$name::replay::first_mismatch(observer_of_$name));"
  done
  for name in "${deterministic[@]}"; do
    echo "  std::printf(\"$name %d\\n\", nlo::$name::replay::first_mismatch(deterministic_$name));"
  done
  echo "}"
} >"$work/main.cpp"

for name in "${coarse[@]}"; do
  grep -q "make_mlp<Activation::kTanh5e5>" "$work/$name.h" || { echo "$name.h does not have the tanh within 5e-5"; exit 1; }
done
for name in van_der_pol rig rig_double rig_bf16 rig_int16 pendulum general driven driven_double; do # compiled alone, because a header must not depend on headers before it
  "$compiler" "${strict[@]}" -fsyntax-only -include "$work/$name.h" -x c++ /dev/null
done

"$compiler" "${strict[@]}" -O1 "$work/main.cpp" -o "$work/main"
failed=0
while read -r name mismatch; do
  [ "$mismatch" -eq -1 ] || { echo "$name: sample $mismatch differs from the equations"; failed=1; }
done < <("$work/main")

# Headers state their size for targets without vectors.
{
  echo "#include <cstdio>"
  for entry in "${exports[@]}"; do echo "#include \"${entry%%:*}.h\""; done
  echo "int main() {"
  for entry in "${exports[@]}"; do
    echo "  std::printf(\"${entry%%:*} %zu\\n\", sizeof(nlo::${entry%%:*}::Model));"
  done
  echo "}"
} >"$work/sizes.cpp"
"$compiler" "${strict[@]}" -DNLO_SCALAR_KERNELS "$work/sizes.cpp" -o "$work/sizes"
while read -r name bytes; do
  stated=$(sed -n 's|^//   kModel  *\([0-9,]*\) bytes.*|\1|p' "$work/$name.h" | tr -d ,)
  [ "$stated" = "$bytes" ] || { echo "$name: kModel has $bytes bytes, its header states $stated"; failed=1; }
done < <("$work/sizes")
[ "$failed" -eq 0 ] || exit 1

# Controls, in one program: exports with other weights, with another tanh, or with one weight of the last layer changed
# by half a percent must fail; by more if weights are rounded by as much.
controls=()
for pair in rig_bf16:rig van_der_pol_fp16:van_der_pol van_der_pol_coarse:van_der_pol; do
  IFS=: read -r name exact <<<"$pair"
  sed "s/nlo::$exact::/nlo::$name::/" "$work/${exact}_replay.h" >"$work/${name}_replay.h"
  controls+=("$name:$pair")
done
for entry in rig:float:1.005 rig:float,fp16:1.02 rig:float,bf16:1.1 rig:int16:1.05 tiny_tanh:int16:1.05 pendulum:float:1.005 general:float:1.005 driven:float:1.005 rig_error:float:1.005 gated_error:double:1.0001; do
  IFS=: read -r example scalar factor <<<"$entry"
  name=altered_${#controls[@]}
  "$export_model" $example replay $scalar $name "$work/${name}_replay.h"
  "$export_model" $example cpp $scalar $name "$work/$name.h" "$factor"
  controls+=("$name:$entry")
done
{
  for control in "${controls[@]}"; do
    echo "#include \"${control%%:*}.h\""
    echo "#include \"${control%%:*}_replay.h\""
  done
  echo "#include <cstdio>"
  for control in "${controls[@]}"; do
    echo "constinit static nlo::${control%%:*}::Observer observer_of_${control%%:*}{nlo::${control%%:*}::kModel};"
  done
  echo "int main() {"
  for control in "${controls[@]}"; do
    echo "  std::printf(\"${control#*:} %d\\n\", nlo::${control%%:*}::replay::first_mismatch(observer_of_${control%%:*}));"
  done
  echo "}"
} >"$work/control.cpp"
"$compiler" "${strict[@]}" -O1 "$work/control.cpp" -o "$work/control"
seen=0
while read -r what mismatch; do
  [ "$mismatch" -ne -1 ] || { echo "$what: passes, but must fail"; exit 1; }
  seen=$((seen + 1))
done < <("$work/control")
[ "$seen" -eq "${#controls[@]}" ] || { echo "$seen of ${#controls[@]} controls ran"; exit 1; }
echo "${#exports[@]} headers by $compiler agree with their models; altered ones do not agree"

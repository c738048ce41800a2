#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# nlo export --check: exports of each structure pass. If the compiler is made to break an export, the error says so and
# nothing is written.
#   check.sh NLO EXPORT_MODEL C_COMPILER [all]
set -euo pipefail
nlo=$1 export_model=$2 cc=$3
examples='rig failing gated driven pendulum general carried prior'
if [[ ${4:-} == all ]]; then examples=$("$export_model"); fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
failed=0
fail() { echo "FAILED  $*" && failed=1; }

for example in $examples; do
  "$export_model" "$example" model float "$example" "$example.json"
  "$nlo" export "$example.json" --target c99 --check -o "$example.h" >"$example.log" || fail "$example"
  grep -q "^$example.h and .c: compiled.* same bits$" "$example.log" || fail "$example: $(cat "$example.log")"
done
for target in cpp single; do
  "$nlo" export rig.json --target $target --check -o $target.h >$target.log || fail $target
  grep -q 'agrees with the model over 400 samples' $target.log || fail "$target: $(cat $target.log)"
done

# broken WHAT SED WORDS: uses a compiler that sees a program which differs from the generated one.
broken() {
  printf '#!/bin/sh\nsed -i "%s" rig*.c\nexec %s "$@"\n' "$2" "$cc" >broken_cc
  chmod +x broken_cc
  if CC="$work/broken_cc" "$nlo" export rig.json --target c99 --check --name rig_broken -o rig_broken.h 2>broken.log; then
    fail "$1: it was exported"
  fi
  grep -q "$3" broken.log || fail "$1: $(cat broken.log)"
  if [[ -e rig_broken.h || -e rig_broken.c ]]; then fail "$1: something was written"; fi
}
broken 'a sign of the step' 's/z\[r\] += change\[r\]/z[r] -= change[r]/' 'sample .* of the replay gives'
broken 'a bias that is left out' 's/sum0 = bias\[0\]/sum0 = 0.0f/' 'the difference exceeds .* explains'
broken 'a status' 's/now = counted_on(health\[j\], 1U, 1U)/now = 0U/' 'the status .*, but the model'
broken 'another order of a sum' 's/total += weights\[i\] \* in\[i\]/total = (weights[i] * in[i] * 1.0000002f) + total/' 'bit for bit'
broken 'no program' 's/^typedef float Scalar;/typedef float/' 'install a C compiler'
if CC="$work/none" "$nlo" export rig.json --target c99 --check --name none -o none.h 2>none.log; then fail 'a compiler that is not there'; fi
grep -q 'in CC' none.log || fail "none: $(cat none.log)"
if "$nlo" export rig.json --target replay --check -o r.h 2>replay.log; then fail 'an export without observer'; fi
grep -q 'leave --check out' replay.log || fail "replay: $(cat replay.log)"
exit $failed

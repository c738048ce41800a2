#!/bin/bash
# SPDX-License-Identifier: MIT
# From a plant to a running observer, on a machine that may have nothing but git: train, evaluate, export, fly.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

usage() {
  cat <<'USAGE'
usage: ./demo.sh [--seconds N]

Trains an observer for a Van der Pol oscillator whose position is measured with noise, evaluates it, exports it as one
constexpr C++ header, compiles a 1 kHz control loop against that header and runs it. Ends with an HTML report.
Model, header and report go to out/demo, which each run replaces.

  --seconds N  how long the control loop runs (10)

Installs missing Debian packages as root or through sudo; elsewhere names them and stops with exit 2.
USAGE
}

seconds=10
out=out/demo
while (($#)); do
  case $1 in
    --seconds) seconds=${2:-} && shift ;;
    -h | --help) usage && exit 0 ;;
    *) usage >&2 && exit 2 ;;
  esac
  shift || true
done
[[ $seconds =~ ^[0-9]+$ && $seconds -ge 1 ]] || { usage >&2 && exit 2; }

source cmake/setup.sh
trap 'printf "%sdemo.sh stopped: the step above did not succeed%s\n" "$red" "$plain" >&2' ERR

need "${build_packages[@]}"

step 'Building nlo (Release)'
# Tests and benchmarks want more packages; test.sh switches them on again in the same build.
quietly configure-release cmake --preset release -DNLO_TESTS=OFF -DNLO_BENCH=OFF -DNLO_EXAMPLES=OFF
build build/release nlo
nlo=build/release/trainer/nlo
started=$SECONDS

step 'Training: learned eigenvalues and inverse map, on noisy measurements'
"$nlo" train trainer/experiments/van_der_pol.toml -o "$out" >"$logs/train.log"

step 'Evaluating on 200 new trajectories; only the position x1 is measured, with noise N(0, 0.5)'
"$nlo" evaluate "$out/model.json" --noise gaussian:0.5 --against ekf 2>"$logs/evaluate.log" | sed '1,2d'
note 'norm: root mean square error of both states. The EKF knows the plant and the noise exactly.'

step 'A monitor that says when an estimate is not to be trusted'
"$nlo" monitor "$out/model.json" --quick >"$logs/monitor.log" 2>&1
note "$(grep -m 1 '^limits' "$logs/monitor.log")"
note "conditions and sensor faults that it was tried on: $logs/monitor.log"

step 'Exporting the constexpr header'
"$nlo" export "$out/model.json" --target cpp -o "$out/van_der_pol.h"
note "$(wc -l <"$out/van_der_pol.h") lines; it begins:"
head -n 5 "$out/van_der_pol.h" | sed 's/^/   | /'

step 'Compiling the control loop against it, as a user of the installed package would'
quietly install cmake --install build/release --prefix build/demo/nlo
quietly configure-control-loop cmake -G Ninja -S examples/control_loop -B build/demo/control_loop \
  -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$PWD/build/demo/nlo" -DVAN_DER_POL_HEADER_DIR="$(realpath "$out")"
build build/demo/control_loop

step "Running it at 1 kHz"
build/demo/control_loop/control_loop --seconds "$seconds" --json "$out/control_loop.json"

"$nlo" report "$out" --noise none --noise gaussian:0.5 --noise uniform:3 --against ekf >"$logs/report.log"

step "Done in $((SECONDS - started)) s, the build apart"
note "model   $out/model.json"
note "header  $out/van_der_pol.h"
note "report  $(realpath "$out/report.html")"

step 'Next: an observer for your plant or your log'
note "export PATH=\"$PWD/build/release/trainer:\$PATH\""
note 'nlo new plant -o my_plant.toml  # or: nlo new log LOGS -o my_log.toml'
note 'nlo train my_plant.toml         # then evaluate, monitor and export runs/my_plant/model.json'

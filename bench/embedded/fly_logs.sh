# SPDX-License-Identifier: MIT
# shellcheck shell=sh disable=SC2154 # source and build
# Source this file in scripts that run exported observers over whole logs on an emulated Cortex-M4F (fly_log.cpp). They set
#   source  folder of this repository
#   build   folder of the cross build

# build_observers CMAKE NLO MODEL... builds fly_NAME.elf and idle_NAME.elf for each NAME.json.
build_observers() {
  cmake=$1 nlo=$2
  shift 2
  models='' targets=''
  for model; do
    name=$(basename "$model" .json)
    models="$models;$model" targets="$targets fly_$name idle_$name"
  done
  # shellcheck disable=SC2086 # names of targets
  { "$cmake" -S "$source" -B "$build" -G Ninja --toolchain "$source/toolchains/cortex-m4f.cmake" \
    -DCMAKE_BUILD_TYPE=Release -DNLO_PROGRAM="$nlo" -DNLO_FLOWN_MODELS="${models#;}" &&
    "$cmake" --build "$build" --target $targets; } >"$build.log" 2>&1 || { cat "$build.log" >&2; return 1; }
}

# fly NAME CSV runs the observer over the inputs that `nlo evaluate --estimates` wrote. Prints the numbers of
# fly_log.cpp without the words, and the largest "apart" of all states at the end:
#   samples ok domain instructions most period observer apart
fly() {
  mkdir -p "$build/flight_$1" && cp "$2" "$build/flight_$1/flight.csv"
  said=$(cd "$build/flight_$1" &&
    "$source/tests/embedded/run_on_board.sh" mps2-an386 "$build/bench/embedded/fly_$1.elf") ||
    { echo "fly_$1 over $2: $said" >&2; return 1; }
  echo "$said" | awk '
    $1 == "samples" { numbers = $2 " " $4 " " $6 " " $8 " " $10 " " $12 " " $14 }
    $1 == "state" && $4 > apart { apart = $4 }
    END { print numbers, apart + 0 }'
}

# agrees SAMPLES DOMAIN APART: succeeds if the estimates differ by less than 1e-4 of the RMS of the state, and if in_domain()
# differs from the trainer's in at most one of a thousand samples (at the edge of the domain a rounding decides).
agrees() {
  [ "$1" -gt 1 ] && [ "$3" -le 100000 ] && [ $((($1 - $2) * 1000)) -le "$1" ]
}

#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Hostile flights of each shipped experiment of a plant, and of the pendulum from logs: trained for a few steps, given a
# monitor, exported in each format and language that supports it, compiled with sanitizers and flown.
#   hostile_shipped.sh NLO EXPORT_MODEL SOURCE_DIR MILLIONS [EXPERIMENT...]   MILLIONS: total number of steps
set -euo pipefail
nlo=$1 export_model=$2 source=$3 millions=$4
shift 4
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
experiments=("$@")
if (($# == 0)); then
  mapfile -t experiments < <(cd "$source/trainer/experiments" && grep -l '^\[plant\]' *.toml plants/*.toml paper/*.toml \
    hyperkkl/*.toml | sed 's/\.toml$//')
  experiments+=("$source/tests/data/pendulum/pendulum.toml")
fi

# For each model, its crafts: name and export format.
crafts=()
for experiment in "${experiments[@]}"; do
  name=${experiment##*/} name=${name%.toml} folder=$work/${experiment//\//_}
  brief=(--set training.steps=3 --set training.validate_every=3 --threads 1 -q)
  if [[ $experiment == *.toml ]]; then brief+=(--data "$(dirname "$experiment")"); else brief+=(--set simulation.trajectories=6); fi
  file=$experiment
  [[ $experiment == *.toml ]] || file=$source/trainer/experiments/$experiment.toml
  (cd "$work" && "$nlo" train "$file" "${brief[@]}" -o "$folder" >"$folder.txt" 2>&1) || [[ -f $folder/model.json ]] ||
    { echo "FAILED  $experiment was not trained" && tail -n 5 "$folder.txt" && exit 1; }
  "$nlo" monitor "$folder/model.json" --hours 0.02 --runs 0 >"$folder.txt" 2>&1 || true # for some plants these runs are too short for a monitor
  mv "$folder/model.json" "$work/${experiment//[^a-zA-Z0-9]/_}.json"
  model=$work/${experiment//[^a-zA-Z0-9]/_}.json
  for kind in cpp_float cpp_double cpp_int16 c99_float c99_double c99_int16; do crafts+=("$kind:$model"); done
done
NLO_SKIP_REFUSED=1 "$source/tests/fuzz/write_fleet.sh" "$export_model" "$work/fleet" "${crafts[@]}" 2>"$work/refused.txt"
flags=(-O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=all -I "$source" -I "$source/runtime/include")
cd "$work/fleet"
printf '%s\n' ./*.cpp "$source/tests/fuzz/hostile_flight.cpp" |
  xargs -P "$(nproc)" -I {} sh -c 'clang++ -std=c++20 "$@" -c {} -o $(basename {}).o' _ "${flags[@]}"
for file in ./*.c; do clang -std=c99 "${flags[@]}" -c "$file" -o "$file.o"; done
clang++ "${flags[@]}" ./*.o -o hostile_flight
./hostile_flight "$millions"

#!/bin/sh
# SPDX-License-Identifier: MIT
# Configures and builds the cross build of a core. BUILD_DIR/models holds the model files for which calls are bounded.
#   usage: build_core.sh CMAKE SOURCE_DIR TOOLCHAIN BUILD_DIR NLO EXPORT_MODEL MODEL...
set -eu
cmake=$1 source=$2 toolchain=$3 build=$4 nlo=$5 export_model=$6
shift 6
mkdir -p "$build/models"
models=
for name in "$@"; do
  "$export_model" "$name" model float "$name" "$build/models/$name.json"
  models="$models;$build/models/$name.json"
done
"$cmake" -S "$source" -B "$build" -G Ninja --toolchain "$source/toolchains/$toolchain.cmake" \
  -DCMAKE_BUILD_TYPE=Release -DNLO_PROGRAM="$nlo" -DNLO_COUNTED_MODELS="${models#;}" >"$build.log" 2>&1 || { cat "$build.log"; exit 1; }
exec "$cmake" --build "$build"

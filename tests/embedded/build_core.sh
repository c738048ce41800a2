#!/bin/sh
# SPDX-License-Identifier: MIT
# Configures and builds the cross build of a core.
#   usage: build_core.sh CMAKE SOURCE_DIR CORE BUILD_DIR NLO
set -eu
cmake=$1 source=$2 core=$3 build=$4 nlo=$5
"$cmake" -S "$source" -B "$build" -G Ninja --toolchain "$source/toolchains/cortex-$core.cmake" \
  -DCMAKE_BUILD_TYPE=Release -DNLO_PROGRAM="$nlo" >"$build.log" 2>&1 || { cat "$build.log"; exit 1; }
exec "$cmake" --build "$build"

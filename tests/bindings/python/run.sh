#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs a test of the package nlo from the tree, with library and program of a build, and with all example models as
# files.
#   usage: run.sh SOURCE_DIR BUILD_DIR WORK_DIR EXPORT_MODEL PYTHON TEST
set -eu
source=$1 build=$2 work=$3 export_model=$4 python=$5 test=$6
rm -rf "$work"
mkdir -p "$work"
for name in $("$export_model"); do "$export_model" "$name" model float "$name" "$work/$name.json"; done
export NLO_SOURCE_DIR="$source" NLO_TEST_MODELS="$work" NLO_MODEL_LIBRARY="$build/bindings/c/libnlo-model.so"
export NLO_PROGRAM="$build/trainer/nlo" PYTHONPATH="$source/bindings/python" PYTHONDONTWRITEBYTECODE=1
exec "$python" "$(dirname "$0")/$test"

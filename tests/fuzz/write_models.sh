#!/bin/sh
# SPDX-License-Identifier: MIT
# Writes the example models as files, and their list for libFuzzer.
#   write_models.sh EXPORT_MODEL FOLDER LIST [MORE_FILES...]
set -eu
export_model=$1 folder=$2 list=$3
shift 3
mkdir -p "$folder"
for example in $("$export_model"); do
  "$export_model" "$example" model float "$example" "$folder/$example.json"
  set -- "$folder/$example.json" "$@"
done
(IFS=, && printf %s "$*") >"$list"

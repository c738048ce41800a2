#!/bin/sh
# SPDX-License-Identifier: MIT
# Writes exports and their crafts (craft.h, c99_craft.h) into FOLDER: a source for each kind, one for each export in
# C99, and one with the table of all.
#   write_fleet.sh EXPORT_MODEL FOLDER KIND:EXAMPLE...   KIND: cpp_float, cpp_double, cpp_int16, c99_float, ...
set -eu
export_model=$1 folder=$2
shift 2
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
count=0
for craft in "$@"; do
  kind=${craft%:*} example=${craft#*:}
  scalar=${kind#*_} language=${kind%_*} name=${example##*/}
  name=$(basename "$name" .json)_$kind
  if ! "$export_model" "$example" "$language" "$scalar" "$name" "$name.h"; then
    if [ -z "${NLO_SKIP_REFUSED:-}" ]; then exit 1; fi # e.g. a structure that C99 does not have
    continue
  fi
  header=craft.h
  if [ "$language" = c99 ]; then header=c99_craft.h; fi
  if [ ! -f "fleet_$kind.cpp" ]; then printf '#include "tests/fuzz/%s"\n' "$header" >"fleet_$kind.cpp"; fi
  printf '#include "%s.h"\n' "$name" >>"fleet_$kind.cpp"
  if [ "$language" = c99 ]; then
    inputs=$(sed -n "s/.* ${name}_NU = \([0-9]*\).*/\1/p" "$name.h")
    if [ "$scalar" = int16 ]; then scalar=float; fi # only T* is int16
    watched=$(sed -n "s/^${name}_alarm ${name}_watch(.*/WATCHED_/p" "$name.h")
    echo "NLO_C99_${watched}CRAFT($name, $scalar, ${inputs:-0})" >>"fleet_$kind.cpp"
  elif grep -q 'using Monitor ' "$name.h"; then
    echo "NLO_WATCHED_CRAFT($name)" >>"fleet_$kind.cpp"
  else
    echo "NLO_CPP_CRAFT($name)" >>"fleet_$kind.cpp"
  fi
  echo "void fly_$name(nlo::hostile::Bits& bits, long steps);" >>declared.inc
  echo "  {\"$name\", fly_$name}," >>rows.inc
  count=$((count + 1))
done
{
  printf '#include "tests/fuzz/craft.h"\n'
  cat declared.inc
  printf 'namespace nlo::hostile {\nconst NamedCraft kFleet[] = {\n'
  cat rows.inc
  printf '};\nconst int kFleetSize = %s;\n}\n' "$count"
} >fleet.cpp

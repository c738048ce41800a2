#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# FMUs of example models: their descriptions follow FMI 3.0 and 2.0. Their binaries, and the binaries that their build
# description builds with sanitizers, give the bits of the C99 pair and pass load_fmu.c. Controls show that each fault
# would be detected. With NLO_FMI_SCHEMA, the folder `schema` of the standard's repository, they are also checked
# against the standard's own schema.
#   run_fmu.sh EXPORT_MODEL SOURCE_DIR C_COMPILER EXAMPLE:SCALAR... (all: all that C99 supports)
set -euo pipefail
export_model=$1 source=$2 tests=$2/tests/fmi cc=$3
shift 3
for program in "$cc" xmllint unzip; do
  command -v "$program" >/dev/null || { echo "SKIPPED: no $program here"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
strict=(-std=c99 -O1 -g -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Wstrict-prototypes -Wmissing-prototypes -Werror)
sanitizers=(-fsanitize=address,undefined -fno-sanitize-recover=all)
fail() { echo "FAILED  $*" && exit 1; }

# valid FILE SCHEMA: expects that FILE follows SCHEMA.
valid() {
  xmllint --noout --relaxng "$tests/descriptions.rng" "$1" 2>"$work/xmllint.txt" || { cat "$work/xmllint.txt"; return 1; }
  if [[ -n ${NLO_FMI_SCHEMA:-} ]]; then xmllint --noout --schema "$NLO_FMI_SCHEMA/$2" "$1"; fi
}

# built FOLDER LIBRARY: compiles the sources that the build description of an FMU lists into a shared library.
built() {
  local files description=$1/sources/buildDescription.xml
  [[ -e $description ]] || description=$1/modelDescription.xml
  mapfile -t files < <(sed -n 's/.*<\(Source\)\?File name="\([^"]*\)".*/\2/p' "$description")
  (cd "$1/sources" && "$cc" "${strict[@]}" "${sanitizers[@]}" -fPIC -shared "${files[@]}" -o "$2")
}

# loaded FOLDER LIBRARY: expects that load_fmu.c passes for the model whose name is that of the folder.
loaded() { "$work/load_$(basename "$1")" "$2" "$1/modelDescription.xml"; }

entries=("$@")
if [[ $1 == all ]]; then
  entries=()
  for example in $("$export_model"); do
    if "$export_model" "$example" fmu-sources float "$example" "$work/all.fmu" 2>"$work/refused.txt"; then
      entries+=("$example:float")
    else
      grep -q 'target fmu writes' "$work/refused.txt" || { cat "$work/refused.txt" && exit 1; }
    fi
  done
fi
for entry in "${entries[@]}"; do
  name=${entry%:*} scalar=${entry#*:} fmu=$work/${entry%:*} driven=()
  rm -rf "$fmu" && mkdir "$fmu"
  CC=$cc "$export_model" "$name" fmu "$scalar" "$name" "$work/$name.fmu"
  unzip -tq "$work/$name.fmu" && unzip -q "$work/$name.fmu" -d "$fmu"
  "$export_model" "$name" replay-c99 "$scalar" "$name" "$work/${name}_replay.h"
  valid "$fmu/modelDescription.xml" fmi3ModelDescription.xsd || fail "modelDescription.xml of $name"
  valid "$fmu/sources/buildDescription.xml" fmi3BuildDescription.xsd || fail "buildDescription.xml of $name"
  if grep -q "${name}_NU" "$fmu/sources/$name.h"; then driven=(-DNLO_DRIVEN); fi
  if grep -q "${name}_watch" "$fmu/sources/$name.h"; then driven+=(-DNLO_MONITORED); fi
  "$cc" -std=gnu11 -O1 -g -Wall -Wextra -Werror "${sanitizers[@]}" -I"$source" -I"$fmu/sources" -DNLO_NAME="$name" -DNLO_SCALAR="${scalar/int16/float}" \
    "${driven[@]}" -include "$work/${name}_replay.h" -include "${name}_fmi3.h" "$tests/load_fmu.c" "$fmu/sources/$name.c" \
    -ldl -lm -o "$work/load_$name"
  built "$fmu" "$work/$name.so"
  loaded "$fmu" "$fmu/binaries/$(uname -m)-linux/$name.so" && loaded "$fmu" "$work/$name.so" || fail "$entry"

  # The FMU by FMI 2.0.
  fmu2=$work/fmi2/$name machine=$(uname -m)-linux
  rm -rf "$fmu2" && mkdir -p "$fmu2"
  CC=$cc "$export_model" "$name" fmu2 "$scalar" "$name" "$work/$name.fmu2"
  unzip -q "$work/$name.fmu2" -d "$fmu2"
  valid "$fmu2/modelDescription.xml" fmi2ModelDescription.xsd || fail "modelDescription.xml of $name by FMI 2.0"
  "$cc" -std=gnu11 -O1 -g -Wall -Wextra -Werror "${sanitizers[@]}" -I"$source" -I"$fmu2/sources" -DNLO_NAME="$name" \
    -DNLO_SCALAR="${scalar/int16/float}" "${driven[@]}" -include "$fmu2/sources/$name.h" \
    -include "$work/${name}_replay.h" -include "${name}_fmi2.h" "$tests/load_fmu2.c" "$fmu2/sources/$name.c" -ldl -lm -o "$work/load2_$name"
  built "$fmu2" "$work/$name.so"
  "$work/load2_$name" "$fmu2/binaries/${machine/x86_64-linux/linux64}/$name.so" "$fmu2/modelDescription.xml" &&
    "$work/load2_$name" "$work/$name.so" "$fmu2/modelDescription.xml" || fail "$entry by FMI 2.0"
  echo "ok      $entry"
done

# Two exports have the same bytes. The export without a binary has the same files except the binary.
"$export_model" "$name" fmu-sources "$scalar" "$name" "$work/sources.fmu"
mkdir "$work/sources" && unzip -q "$work/sources.fmu" -d "$work/sources"
[[ $(diff -rq "$work/sources" "$fmu") == "Only in $fmu: binaries" ]] || fail 'the FMU of sources has other files'
CC=$cc "$export_model" "$name" fmu "$scalar" "$name" "$work/again.fmu" && cmp "$work/again.fmu" "$work/$name.fmu"

# Two FMUs linked into one program: their functions have different names.
"$cc" -std=c99 -DFMI3_FUNCTION_PREFIX="${name}_" -c "$fmu/sources/${name}_fmi3.c" -o "$work/linked.o"
nm "$work/linked.o" | grep -q " T ${name}_fmi3DoStep" || fail 'the prefix of functions is not used'

# Without a compiler nothing is written, and the error says what to do.
for compiler in no-such-compiler false; do
  ! CC=$compiler "$export_model" "$name" fmu "$scalar" "$name" "$work/none.fmu" 2>"$work/said.txt" || fail 'an FMU without a compiler'
  [[ ! -e $work/none.fmu ]] && grep -q 'no binary for the FMU: .*--target fmu-sources' "$work/said.txt" || fail "$(cat "$work/said.txt")"
done

# Controls: one weight changed by half a percent under the same token; a state that instances share; an estimate that is
# one step old; attributes that FMI does not have, and elements in the wrong order.
altered() { # WHAT: expects that the library built from $work/altered fails
  built "$work/altered/$name" "$work/altered.so"
  ! loaded "$fmu" "$work/altered.so" >"$work/said.txt" || fail "$1 was not detected"
  grep -q '^FAILED  line' "$work/said.txt" || fail "$1: $(cat "$work/said.txt")"
}
fresh() { rm -rf "$work/altered" && mkdir "$work/altered" && cp -r "$fmu" "$work/altered/$name"; }
fresh
"$export_model" "$name" c99 "$scalar" "$name" "$work/altered/$name/sources/$name.h" 1.005
altered 'a wrong weight'
fresh
sed -i 's/Instance\* const i = calloc(1, sizeof(Instance));/static Instance shared; Instance* const i = \&shared;/; s/{ free(instance); }/{ (void)instance; }/' \
  "$work/altered/$name/sources/${name}_fmi3.c"
altered 'a shared state'
fresh
sed -i 's/  i->is_estimated = false;//' "$work/altered/$name/sources/${name}_fmi3.c"
altered 'an old estimate'
sed 's/causality="output"/causality="out"/' "$fmu/modelDescription.xml" >"$work/wrong.xml"
! valid "$work/wrong.xml" fmi3ModelDescription.xsd >"$work/said.txt" 2>&1 || fail 'a wrong attribute was not detected'
sed 's/<InitialUnknown/<Swapped/; s/<Output/<InitialUnknown/; s/<Swapped/<Output/' "$fmu/modelDescription.xml" >"$work/wrong.xml"
! valid "$work/wrong.xml" fmi3ModelDescription.xsd >"$work/said.txt" 2>&1 || fail 'a wrong order was not detected'
sed 's/ variability="discrete"//' "$fmu2/modelDescription.xml" >"$work/wrong.xml"
! valid "$work/wrong.xml" fmi2ModelDescription.xsd >"$work/said.txt" 2>&1 || fail 'a status that varies continuously was not detected'
sed -i 's/is_initial ? kInitialLatent : kLatent,/is_initial ? kLatent : kInitialLatent,/' "$fmu2/sources/${name}_fmi2.c"
built "$fmu2" "$work/altered.so"
! "$work/load2_$name" "$work/altered.so" "$fmu2/modelDescription.xml" >"$work/said.txt" || fail 'the initial state in place of z was not detected'

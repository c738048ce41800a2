#!/bin/sh
# SPDX-License-Identifier: MIT
# libnlo-model as a C program uses it: installed into an empty folder, found by pkg-config, compiled as strict C99 and
# as C++, and tested with the golden inputs of each structure that `nlo export` writes in C99.
#   usage: installed.sh SOURCE_DIR BUILD_DIR WORK_DIR EXPORT_MODEL
set -eu
source=$1 build=$2 work=$3 export_model=$4
command -v pkg-config >/dev/null || { echo "skipped: there is no pkg-config"; exit 77; }
rm -rf "$work"
mkdir -p "$work/golden"

fail() {
  echo "FAILED: $*"
  exit 1
}
cmake --install "$build" --component model --prefix "$work/first" >"$work/install.log"
mv "$work/first" "$work/prefix" # an installed folder must be movable
library=$(find "$work/prefix" -name 'libnlo-model.so')
directory=$(dirname "$library")
export PKG_CONFIG_PATH="$directory/pkgconfig" LD_LIBRARY_PATH="$directory"

# Check its visible names and the libraries that it needs.
nm -D --defined-only "$library" | awk '$2 != "A" && $3 !~ /^nlo_/ { print; bad = 1 } END { exit bad }' || fail 'the library exports other names'
declared=$(grep -c '^NLO_API' "$source/bindings/c/nlo_model.h")
shown=$(nm -D --defined-only "$library" | grep -c ' T nlo_')
[ "$declared" -eq "$shown" ] || fail "nlo_model.h declares $declared functions, the library shows $shown"
needs=$(objdump -p "$library" | awk '/NEEDED/ { print $2 }' | grep -vE '^(libm|libc|ld-linux.*)\.so' || true)
case $needs in '' | libclang_rt* | libasan*) ;; *) fail "it needs $needs" ;; esac
objdump -p "$library" | grep -q 'SONAME  *libnlo-model\.so\.[0-9]' || fail 'no soname with a version'

strict='-std=c99 -Wall -Wextra -pedantic -Wconversion -Werror'
# shellcheck disable=SC2046,SC2086
compile() { cc $strict "$@" $(pkg-config --cflags --libs nlo-model); }
compile "$source/bindings/c/estimate.c" -o "$work/estimate"
# shellcheck disable=SC2046
echo '#include <nlo_model.h>
int main() { return nlo_abi_version() == NLO_MODEL_ABI ? 0 : 1; }' >"$work/user.cpp"
# shellcheck disable=SC2046
c++ -std=c++11 -Wall -Wextra -pedantic -Werror "$work/user.cpp" -o "$work/user" $(pkg-config --cflags --libs nlo-model)
"$work/user" || fail 'the interface has another number than its header'

estimates=$(printf '0.5\n0.51\nnan\n0.53\n' | "$work/estimate" "$source/examples/models/van_der_pol.json")
echo "$estimates"
[ "$(echo "$estimates" | wc -l)" -eq 5 ] || fail 'four samples should give four estimates and a heading'
echo "$estimates" | grep -q 'held 1$' || fail 'a missing reading should be held'
head -c 500 "$source/examples/models/van_der_pol.json" >"$work/cut.json"
if error=$("$work/estimate" "$work/cut.json" 2>&1 </dev/null); then fail 'half a model file is accepted'; fi
echo "$error" | grep -qF "$work/cut.json:" || fail "the error does not name the file: $error"

# size FIELD: prints the number of floats of FIELD in a golden sample
size() { sed -n "s/^  float $1\[\([0-9]*\)\];/\1/p" "$work/golden/replay.h"; }
replayed=0
for name in $("$export_model"); do
  "$export_model" "$name" model float "$name" "$work/golden/model.json"
  # An export subtracts whole turns of an angle from z; the interface may keep them, so z may differ.
  if grep -q '"wrap": *[1-9]' "$work/golden/model.json"; then continue; fi
  "$export_model" "$name" replay-c99 float "$name" "$work/golden/replay.h" 2>/dev/null || continue # no C99 for this model
  : >"$work/golden/$name.h" # the header includes that of the exported observer, which golden.c replaces
  nu=$(size u)
  compile -I"$work/golden" -DGOLDEN_NAME="$name" -DGOLDEN_REPLAY='"replay.h"' -DGOLDEN_NY="$(size y)" \
    -DGOLDEN_NU="${nu:-0}" -DGOLDEN_NX="$(size x_hat)" -DGOLDEN_NZ="$(size z)" "$(dirname "$0")/golden.c" -o "$work/golden/run"
  "$work/golden/run" "$work/golden/model.json" || fail "golden answers of $name"
  replayed=$((replayed + 1))
done
echo "ok       golden inputs of $replayed models"
[ "$replayed" -ge 20 ] || fail 'too few models were replayed'
"$export_model" tiny replay-c99 float tiny "$work/golden/replay.h"
: >"$work/golden/tiny.h"
"$export_model" tiny model float tiny "$work/golden/model.json" 1.01
compile -I"$work/golden" -DGOLDEN_NAME=tiny -DGOLDEN_REPLAY='"replay.h"' -DGOLDEN_NY=1 -DGOLDEN_NU=0 -DGOLDEN_NX=1 -DGOLDEN_NZ=2 \
  "$(dirname "$0")/golden.c" -o "$work/golden/run"
if "$work/golden/run" "$work/golden/model.json" >/dev/null; then fail 'a wrong weight is not seen: this test proves nothing'; fi

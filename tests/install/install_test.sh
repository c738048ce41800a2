#!/bin/sh
# SPDX-License-Identifier: MIT
# A project outside of this tree finds the installed package, generates a header from a model file and runs.
#   usage: install_test.sh SOURCE_DIR BUILD_DIR WORK_DIR
set -eu
source=$1 build=$2 work=$3
here=$(dirname "$0")
rm -rf "$work"
mkdir -p "$work"
cp -r "$source/examples" "$work/examples" # a copy, so that no relative path reaches this tree

fail() {
  echo "FAILED: $*"
  exit 1
}

cmake --install "$build" --prefix "$work/prefix" >"$work/install.log"
if grep -rlF "$source" "$work/prefix/share" --include='*.cmake'; then fail "the installed package names the source tree"; fi

configure() { cmake -G Ninja -S "$work/examples/minimal" -B "$work/$1" "$2" -DCMAKE_BUILD_TYPE=Release >"$work/$1.log" 2>&1; }
if configure control -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF; then
  fail "the example configures without the installed package, so this test proves nothing"
fi
configure minimal "-DCMAKE_PREFIX_PATH=$work/prefix" || { cat "$work/minimal.log"; exit 1; }
cmake --build "$work/minimal"

estimates=$(printf '0.5\n0.51\n0.52\n' | "$work/minimal/minimal")
echo "$estimates"
[ "$(echo "$estimates" | wc -l)" -eq 3 ] || fail "three measurements should give three estimates"
"$work/prefix/bin/nlo" --help | head -n 3
"$work/prefix/bin/nlo" reproduce --help | grep -q table1-control || fail "nlo reproduce does not find its program"

"$work/prefix/bin/nlo" export "$work/examples/models/van_der_pol.json" --quiet -o "$work/van_der_pol.h"
sh "$here/components_test.sh" "$source" "$work"

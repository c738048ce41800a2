#!/bin/sh
# SPDX-License-Identifier: MIT
# Measures how long a compiler takes for exported headers, for the runtime alone, and for <iostream> in the same run.
#   usage: bench/compile_time.sh HEADER...     prints the medians of 9 runs of ${CXX:-g++} ${CXXFLAGS:--O2} [s]
set -eu
[ $# -gt 0 ] || { sed -n 's/^# \{0,3\}//; 3,4p' "$0" >&2; exit 2; }
runtime=$(cd "$(dirname "$0")/../runtime/include" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# CXXFLAGS are several words.
# shellcheck disable=SC2086
compile() { "${CXX:-g++}" -std=c++20 ${CXXFLAGS:--O2} -I "$runtime" -c "$1" -o "$work/object.o"; }

# report SOURCE NAME: the median of 9 compilations
report() {
  compile "$1"
  for _ in 1 2 3 4 5 6 7 8 9; do
    before=$(date +%s%N)
    compile "$1"
    echo $(($(date +%s%N) - before))
  done | sort -n | awk '{t[NR] = $1} END {printf "%.3f  ", t[5] / 1e9}'
  echo "$2"
}

printf '#include <iostream>\n' > "$work/reference.cpp"
printf '#include <nlo/kkl_observer.h>\n' > "$work/runtime.cpp"
report "$work/reference.cpp" "<iostream>"
report "$work/runtime.cpp" "the runtime alone: nlo/kkl_observer.h"
for header; do
  name=$(sed -n 's/^namespace nlo::\([a-z_0-9A-Z]*\) {.*/\1/p' "$header" | head -1)
  [ -n "$name" ] || { echo "compile_time.sh: $header: no header that nlo export has written" >&2; exit 1; }
  # Runs a step and an estimate, because a template that is not used takes no time to compile.
  printf '#include "%s"\nauto run(nlo::%s::Observer& o, const nlo::%s::Observer::Output& y) { (void)o.step(y); return o.estimate(); }\n' \
    "$(cd "$(dirname "$header")" && pwd)/$(basename "$header")" "$name" "$name" > "$work/header.cpp"
  report "$work/header.cpp" "$header"
done

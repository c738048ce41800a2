#!/bin/sh
# SPDX-License-Identifier: MIT
# In C++17, each runtime header and an exported header give one #error, and the compilation ends there.
#   usage: old_language.sh COMPILER SOURCE_DIR EIGEN_INCLUDE_DIR WORK_DIR
set -eu
compiler=$1 source=$2 eigen=$3 work=$4
mkdir -p "$work"
mend='nlo needs C\+\+20: compile with -std=c\+\+20'

# complaint LANGUAGE HEADER: prints the compiler's messages for a source that includes the header
complaint() {
  echo "#include <$2>" >"$work/includes.cpp"
  "$compiler" -std="$1" -I"$source/runtime/include" -I"$source/tests/golden" -isystem "$eigen" -fsyntax-only \
    "$work/includes.cpp" 2>&1 || true
}

failures=0 count=0
for header in $(cd "$source/runtime/include" && find nlo -name '*.h' | sort) tiny.h; do
  count=$((count + 1))
  said=$(complaint c++17 "$header")
  # The #error, and the compiler's own message that it ends here.
  errors=$(echo "$said" | grep -c 'error: ' || true)
  if [ "$errors" -ne 2 ] || [ "$(echo "$said" | grep -cE "error: .*$mend" || true)" -ne 1 ]; then
    echo "FAILED   $header in C++17: $errors errors"
    echo "$said" | head -n 20
    failures=$((failures + 1))
  fi
done
echo "$count headers, $failures that C++17 does not end with one #error"
# Control: C++20 gives no message.
said=$(complaint c++20 tiny.h)
if [ -n "$said" ]; then
  echo "FAILED   control: tiny.h in C++20: $said"
  failures=$((failures + 1))
fi
[ "$count" -gt 4 ] && exit $((failures > 0))

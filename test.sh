#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs all tests that a change must pass, on a machine that may have only git. The second run is quick.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

usage() {
  cat <<'USAGE'
usage: ./test.sh [--quick | --full | --claims | --places | --fuzz MINUTES]

  (none)    release build and all tests; the quick part of the ledger of results (trains, exports, compiles and runs the
            shipped observers, and compares their figures with the published ones); formatting; clang++ build with
            sanitizers
  --quick   release build and all tests only
  --full    also the exhaustive tests (every float, many seeds), more cores, compilers and instruction sets,
            all of the program under sanitizers, coverage of the runtime and of C99, and clang-tidy
  --claims  release build, then measures every figure of README and docs again (some 40 minutes on 2 cores)
  --places  release build, then the script tests in a folder called nlo, in one with a space and an umlaut in its name, as
            a user without privileges or HOME, under a German locale and in another time zone
  --fuzz    clang++ build with sanitizers, then libFuzzer on each target of tests/fuzz for its share of MINUTES

A test whose program and files have not changed since it passed is not run again (tests/unchanged.py). After rm -r build
every test runs again. Installs missing Debian packages as root or by sudo; elsewhere names them and stops with exit 2.
USAGE
}

mode=default
case "${1:-}" in
  '') ;;
  --quick) mode=quick ;;
  --full) mode=full ;;
  --claims) mode=claims ;;
  --places) mode=places ;;
  --fuzz) mode=fuzz ;;
  -h | --help) usage && exit 0 ;;
  *) usage >&2 && exit 2 ;;
esac
if [[ $mode == fuzz ]]; then
  (($# == 2)) && [[ $2 =~ ^[0-9]+([.][0-9]+)?$ ]] || { usage >&2 && exit 2; }
else
  (($# <= 1)) || { usage >&2 && exit 2; }
fi
minutes=${2:-}

source cmake/setup.sh
jobs=$(nproc)
failed=() summary=()

# phase TITLE COMMAND...: a failure is remembered, the phases after it still run.
phase() {
  local title=$1 start=$SECONDS outcome=passed
  shift
  step "$title"
  "$@" || { outcome=FAILED && failed+=("$title"); }
  summary+=("$(printf '%-6s %4d s  %s' "$outcome" $((SECONDS - start)) "$title")")
}

# ctest names what failed, what that program said, and its closing lines; what passed is in build/logs. A suite passes
# with tests that were skipped: these are named at the end.
run_ctest() {
  local preset=$1
  shift
  tests/unchanged.py ctest "build/$preset" -j "$jobs" --no-tests=error "$@" 2>&1 | tee "$logs/ctest-$preset.log" |
    grep --line-buffered -vE '^ +Start +[0-9]+:|^ *[0-9]+/[0-9]+ Test.* Passed |^Test project|^Internal ctest|^$'
  local outcome=${PIPESTATUS[0]}
  grep -hs '^\[  SKIPPED \] [A-Z].*ms)' "build/$preset/Testing/Temporary/LastTest.log" || true
  return "$outcome"
}

release() {
  local full=OFF
  if [[ $mode == full ]]; then full=ON; fi
  quietly configure-release cmake --preset release -DNLO_TESTS=ON -DNLO_EXAMPLES=ON -DNLO_EMBEDDED_TESTS=ON \
    -DNLO_BENCH=ON "-DNLO_SLOW_TESTS=$full" &&
    build build/release &&
    run_ctest release
}

# This build uses clang++ for a second opinion on warnings. Sanitizers watch code that parses, steps and trains; --full
# watches all of it, and does without precompiled headers and joined sources, which takes several times as long and shows
# whether every source includes what it uses. Four checks of every pointer are for --full: they take as long to compile as
# all the others together, and what they would find the address sanitizer sees too, or an emulated Cortex-M0+ that traps.
configure_sanitizers() {
  local quick=ON full=OFF unchecked='-fno-sanitize=null,alignment,object-size,pointer-overflow'
  if [[ $mode == full ]]; then quick=OFF full=ON unchecked=; fi
  quietly configure-asan cmake --preset asan -DCMAKE_CXX_COMPILER=clang++ -DNLO_WARNINGS_AS_ERRORS=ON \
    "-DCMAKE_CXX_FLAGS_DEBUG=-O0 -g1 $unchecked" \
    "-DNLO_CORE_ONLY=$quick" "-DNLO_JOIN_SOURCES=$quick" "-DNLO_EXAMPLES=$full" \
    "-DCMAKE_DISABLE_PRECOMPILE_HEADERS=$full" -DNLO_FUZZ=ON
}
sanitizers() { configure_sanitizers && build build/asan && run_ctest asan -L quick -LE 'audit|install'; }
fuzzing() { configure_sanitizers && build build/asan nlo_fuzz && tests/fuzz/run.sh build/asan "$minutes"; }

# sources FOLDER...: lists sources. It does not ask git, which refuses to read a checkout that belongs to someone else.
# Golden files are left out, because they stay as the generator writes them.
sources() { find "$@" -path tests/golden -prune -o \( -name '*.h' -o -name '*.cpp' -o -name '*.c' \) -print; }

# Logs of the real rigs are read from their usual folder; the option --data of the program names another one. Without
# these logs, the program leaves their figures out and says so.
claims() { build/release/tests/claims/claims "$@"; }
quick_claims() {
  local programs=(build/release/trainer/nlo build/release/tests/claims/claims)
  tests/unchanged.py once build/release claims "${programs[@]}" -- "${programs[1]}" --quick
}

formatting() { sources runtime codegen trainer bindings tests bench examples | xargs clang-format --dry-run --Werror; }

tidy() {
  sources codegen trainer bindings examples | grep '\.cpp$' |
    xargs -P "$jobs" -n 1 clang-tidy -p build/asan --quiet --warnings-as-errors='*' 2>"$logs/clang-tidy.log"
}

need "${build_packages[@]}" "${test_packages[@]}"
if [[ $mode == full ]]; then need mkdocs-material doxygen; fi
if [[ $mode == claims ]]; then
  quietly configure-release cmake --preset release -DNLO_TESTS=ON
  phase 'Release build of the program and the ledger' build build/release nlo claims
  phase 'The ledger of results, all of it' claims
elif [[ $mode == places ]]; then
  need locales
  quietly configure-release cmake --preset release -DNLO_TESTS=ON
  phase 'Release build of what scripts call' build build/release nlo nlo_export_model nlo_write_literals
  phase 'Script tests in other places' tests/properties/any_place.sh . build/release
elif [[ $mode == fuzz ]]; then
  phase "Fuzzing, $minutes minutes" fuzzing
else
  phase 'Release build by g++, all tests' release
  [[ $mode == quick ]] || phase 'The ledger of results, its quick part' quick_claims
fi
if [[ $mode == default || $mode == full ]]; then
  phase 'Formatting' formatting
  phase 'Build by clang++ with address and undefined-behaviour sanitizers, quick tests' sanitizers
fi
if [[ $mode == full ]]; then
  need llvm-cov
  phase 'Coverage of the runtime and of exported C99' tests/coverage/coverage.py
  phase 'clang-tidy' tidy
fi

step "Summary ($SECONDS s)"
printf '   %s\n' "${summary[@]}"
# Printed last, so that the end of the output contains the results of the tests.
[[ $mode == claims || $mode == fuzz || $mode == places ]] || grep -hE 'tests passed|unchanged since they passed' "$logs/ctest-release.log" || true
((${#failed[@]} == 0))

#!/bin/sh
# SPDX-License-Identifier: MIT
# Targets and dependencies of each component of find_package(nlo), and the runtime as a subdirectory.
#   usage: components_test.sh SOURCE_DIR WORK_DIR     WORK_DIR has prefix/ (the installed package) and van_der_pol.h
set -eu
source=$1 work=$2

fail() {
  echo "FAILED: $*"
  exit 1
}

mkdir -p "$work/user"
cp "$(dirname "$0")/flies.cpp" "$work/van_der_pol.h" "$work/user"

# user NAME FIND LIBRARY [CHECK]: writes the project NAME, which finds nlo by the line FIND and links LIBRARY; CHECK:
# more CMake
user() {
  mkdir -p "$work/$1"
  cat >"$work/$1/CMakeLists.txt" <<END
cmake_minimum_required(VERSION 3.25)
project($1 LANGUAGES CXX)
$2
${4:-}
add_executable(flies ../user/flies.cpp)
target_link_libraries(flies PRIVATE $3)
if("$3" STREQUAL "nlo::eigen")
  target_compile_definitions(flies PRIVATE WITH_EIGEN=1)
endif()
END
}
# configured NAME [ARGUMENT...]: succeeds if the project configures with the package in prefix/
configured() {
  name=$1
  shift
  cmake -G Ninja -S "$work/$name" -B "$work/$name/build" -DCMAKE_BUILD_TYPE=Release "-DCMAKE_PREFIX_PATH=$work/prefix" \
    -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF "$@" >"$work/$name.log" 2>&1
}
# flies NAME [ARGUMENT...]: expects that the project configures, builds and runs
flies() {
  configured "$@" || { cat "$work/$1.log"; fail "$1 does not configure"; }
  cmake --build "$work/$1/build" >>"$work/$1.log" 2>&1 || { cat "$work/$1.log"; fail "$1 does not build"; }
  "$work/$1/build/flies" >"$work/$1.out" || fail "$1 does not run"
  echo "ok       $1: $(cat "$work/$1.out")"
}
# refuses NAME WORDS [ARGUMENT...]: expects that the project does not configure and its error has these words
refuses() {
  name=$1 words=$2
  shift 2
  if configured "$name" "$@"; then fail "$name configures"; fi
  tr -s ' \n' ' ' <"$work/$name.log" | grep -qF "$words" || { cat "$work/$name.log"; fail "$name does not say: $words"; }
  echo "ok       $name is refused: $words"
}
no_eigen=-DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON
only_runtime='foreach(target IN ITEMS nlo::eigen nlo::nlo Eigen3::Eigen)
  if(TARGET ${target})
    message(FATAL_ERROR "${target} came with the runtime")
  endif()
endforeach()'

user runtime "find_package(nlo 0.2 REQUIRED COMPONENTS runtime)" nlo::runtime "$only_runtime"
flies runtime
user no_eigen "find_package(nlo REQUIRED)" nlo::runtime 'if(NOT TARGET nlo::nlo OR NOT COMMAND nlo_add_model)
  message(FATAL_ERROR "no program")
endif()'
flies no_eigen $no_eigen
user eigen "find_package(nlo REQUIRED COMPONENTS eigen)" nlo::eigen
flies eigen
user everything "find_package(nlo REQUIRED)" nlo::eigen
flies everything
user eigen_missing "find_package(nlo REQUIRED COMPONENTS eigen)" nlo::eigen
refuses eigen_missing "the component eigen wants Eigen 3.4" $no_eigen
user unknown "find_package(nlo REQUIRED COMPONENTS trainer)" nlo::runtime
refuses unknown "there is no component trainer: the components are runtime, eigen and program"

# The runtime as a subdirectory: a package that it searched for would be in the cache as NAME_DIR, and configuring it
# may take at most a second of processor time.
user subdirectory "set(NLO_RUNTIME_ONLY ON)
add_subdirectory($source nlo)" nlo::runtime "$only_runtime"
flies subdirectory
if found=$(grep '_DIR:PATH=' "$work/subdirectory/build/CMakeCache.txt"); then fail "packages were looked for: $found"; fi

# children_ms: processor time of this shell's children so far. `times` must not run in a subshell, which has no
# children.
children_ms() {
  times >"$work/times.txt"
  children_ms=$(awk 'NR == 2 { gsub("s", ""); for (i = 1; i <= 2; ++i) { split($i, t, "m"); ms += (60 * t[1] + t[2]) * 1000 } print int(ms) }' "$work/times.txt")
}
children_ms
before=$children_ms
cmake -G Ninja -S "$source" -B "$work/runtime_only" -DNLO_RUNTIME_ONLY=ON >"$work/runtime_only.log"
children_ms
took=$((children_ms - before))
echo "ok       NLO_RUNTIME_ONLY: configured in $took ms of processor time"
[ "$took" -gt 0 ] && [ "$took" -lt 1000 ] || fail "NLO_RUNTIME_ONLY takes $took ms to configure; 1 to 999 are expected"

cmake --install "$work/runtime_only" --prefix "$work/runtime_prefix" >"$work/runtime_only.log"
user installed_runtime "find_package(nlo REQUIRED)" nlo::runtime 'if(TARGET nlo::nlo)
  message(FATAL_ERROR "a program came with the runtime")
endif()'
flies installed_runtime "-DCMAKE_PREFIX_PATH=$work/runtime_prefix"
user program_missing "find_package(nlo REQUIRED COMPONENTS program)" nlo::runtime
refuses program_missing "the runtime is installed without the program" "-DCMAKE_PREFIX_PATH=$work/runtime_prefix"

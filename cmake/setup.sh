# SPDX-License-Identifier: MIT
# Sourced by demo.sh and test.sh: prints readable steps and installs the Debian packages that a step needs.
# Packages that are already there are not installed again. The output of a step goes to build/logs and is shown only if the
# step fails.

logs=build/logs
mkdir -p "$logs"
if [[ -t 1 ]]; then bold=$'\e[1m' red=$'\e[31m' green=$'\e[32m' plain=$'\e[0m'; else bold='' red='' green='' plain=''; fi

step() { printf '\n%s== %s%s\n' "$bold" "$*" "$plain"; }
note() { printf '   %s\n' "$*"; }

# quietly LOG COMMAND...: runs the command; if it fails, shows the end of its output.
quietly() {
  local log=$logs/$1.log
  shift
  if ! "$@" >"$log" 2>&1; then
    tail -n 40 "$log" >&2
    printf '%sfailed:%s %s\n   all of its output: %s\n' "$red" "$plain" "$*" "$log" >&2
    return 1
  fi
}

# build DIR [TARGET...]: one line that moves on a terminal, a line per fifth of the work in a log, errors always.
build() {
  local dir=$1 shown=0 line
  shift
  if [[ -t 1 ]]; then
    cmake --build "$dir" ${1:+--target "$@"}
    return
  fi
  NINJA_STATUS='[%f/%t] ' cmake --build "$dir" ${1:+--target "$@"} 2>&1 | while IFS= read -r line; do
    if [[ $line =~ ^\[([0-9]+)/([0-9]+)\]\  ]]; then
      local fifth=$((5 * BASH_REMATCH[1] / BASH_REMATCH[2]))
      if ((fifth > shown)); then note "built ${BASH_REMATCH[1]} of ${BASH_REMATCH[2]}"; fi
      shown=$fifth
    elif [[ $line != 'ninja: Entering'* && $line != 'ninja: no work'* ]]; then
      printf '%s\n' "$line"
    fi
  done
  return "${PIPESTATUS[0]}"
}

# Programs are searched by name, so they may come from elsewhere (a newer compiler, a gnuplot with windows).
declare -A package_of=([g++]=g++ [cmake]=cmake [ninja]=ninja-build [gnuplot]=gnuplot-nox [python3]=python3
  [clang++]=clang [pkg-config]=pkgconf [clang-format]=clang-format [clang-tidy]=clang-tidy [llvm-cov]=llvm)

# need PROGRAM|PACKAGE...: installs missing packages as root or by sudo; otherwise names them and stops with exit 2.
need() {
  [[ -n ${NLO_SKIP_SETUP:-} ]] && return
  local missing=() name
  for name in "$@"; do
    if [[ -n ${package_of[$name]:-} ]]; then
      command -v "$name" >/dev/null || missing+=("${package_of[$name]}")
    elif command -v dpkg-query >/dev/null; then
      [[ $(dpkg-query -W -f='${Status}' "$name" 2>/dev/null) == *' installed' ]] || missing+=("$name")
    else
      missing+=("$name")
    fi
  done
  ((${#missing[@]})) || return 0

  local as_root=()
  if ((EUID != 0)); then as_root=(sudo); fi
  if ! command -v apt-get >/dev/null || { ((EUID != 0)) && ! can_sudo; }; then
    {
      printf 'Missing: %s\n' "${missing[*]}"
      printf 'These are their names in Debian 12. Install them (as root: apt-get install --no-install-recommends %s)\n' \
        "${missing[*]}"
      printf 'and run this again; with NLO_SKIP_SETUP=1 it does not look for packages at all.\n'
    } >&2
    exit 2
  fi
  step "Installing ${#missing[@]} Debian packages: ${missing[*]}"
  local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o Dpkg::Use-Pty=0)
  quietly apt-update "${apt[@]}" update || note 'package lists are not up to date; trying with what is there'
  quietly apt-install "${apt[@]}" install --no-install-recommends "${missing[@]}"
}

# sudo is used if it needs no password, or if there is a terminal to ask for it.
can_sudo() { command -v sudo >/dev/null && { sudo -n true 2>/dev/null || { [[ -t 0 ]] && sudo -v; }; }; }

build_packages=(g++ cmake ninja libeigen3-dev libtoml11-dev libcli11-dev libfmt-dev nlohmann-json3-dev libmuparser-dev
  gnuplot)
test_packages=(libgtest-dev libgmock-dev libbenchmark-dev clang++ libclang-rt-dev clang-format clang-tidy
  gcc-arm-none-eabi libstdc++-arm-none-eabi-newlib qemu-system-arm g++-aarch64-linux-gnu g++-riscv64-linux-gnu qemu-user
  gcc-riscv64-unknown-elf qemu-system-misc gcc-avr avr-libc simavr valgrind python3 python3-numpy python3-scipy python3-venv
  parallel dpkg-dev file help2man pkg-config frama-c-base cppcheck gappa libxml2-utils unzip llvm-14 llvm-19)

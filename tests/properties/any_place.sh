#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs the script tests in copies of the checkout at places where a user may have it: in a folder called nlo, for a user
# without privileges or HOME and with private files; and in a folder with a space and an umlaut in its name, under a
# German locale and another time zone. The programs that the scripts call are copied from BUILD_DIR.
#   usage: any_place.sh SOURCE_DIR BUILD_DIR [--whole]
#     --whole  builds everything there and runs ./test.sh --quick (some 30 minutes for each of the two)
# exit status: 0, or 1 if a test failed at one of the places
set -uo pipefail
source_dir=$(realpath "$1") build_dir=$(realpath "$2") whole=
if [[ ${3:-} == --whole ]]; then whole=yes; fi
work=$(mktemp -d) && chmod 755 "$work"
trap 'rm -rf "$work"' EXIT
failures=0

# The tests that are scripts, without those that take minutes and do not depend on the place.
scripts='^(properties\.|codegen_(c99|wrappers|literals)|replay\.exports|examples\.rig|bench\.performance_page)'

# German number format and time stamps; the locale is built here because few machines have it.
mkdir "$work/locales"
localedef -i de_DE -f UTF-8 "$work/locales/de_DE.UTF-8" 2>/dev/null ||
  echo 'Debian package "locales" is missing: the German locale is left out'

# copy FOLDER: copies the checkout with its changes, without files that were built or written in it
copy() {
  mkdir -p "$1"
  (cd "$source_dir" && tar -c --exclude=./build --exclude=./out --exclude=./runs .) | tar -x -C "$1"
  [[ -n $whole ]] && return
  for program in trainer/nlo tests/codegen/nlo_export_model tests/codegen/nlo_write_literals; do
    install -D "$build_dir/$program" "$1/build/release/$program"
  done
}

# run NAME FOLDER COMMAND...: runs the tests in FOLDER; COMMAND starts a shell in another environment
run() {
  local name=$1 folder=$2
  shift 2
  copy "$folder"
  ((EUID != 0)) || chown -R nobody "$folder"
  local commands='cmake --preset release -DNLO_TESTS=ON -DNLO_EXAMPLES=ON -DNLO_BENCH=ON >configure.log 2>&1 ||
      { tail -n 30 configure.log && exit 1; }
    ctest --test-dir build/release -R "$1" -E any_place --output-on-failure --no-tests=error >ctest.log 2>&1'
  if [[ -n $whole ]]; then commands='NLO_SKIP_SETUP=1 ./test.sh --quick >ctest.log 2>&1'; fi
  if (cd "$folder" && "$@" bash -c "umask 077 && $commands" places "$scripts"); then
    echo "$name: $(grep 'tests passed' "$folder/ctest.log")"
  else
    echo "FAILED   $name, in $folder" && tail -n 60 "$folder/ctest.log" 2>/dev/null
    failures=$((failures + 1))
  fi
}

path=/usr/local/bin:/usr/bin:/bin
nobody=()
if ((EUID == 0)) && ! setpriv --reuid=nobody --regid=nogroup --clear-groups bash -c ': >/dev/null' 2>&1; then
  echo 'users without privileges cannot write to /dev/null on this machine: both places are tried as root'
elif ((EUID == 0)); then
  nobody=(setpriv --reuid=nobody --regid=nogroup --clear-groups)
else
  echo 'not root: both places are tried as this user'
fi
run 'a folder called nlo, a user without privileges, no HOME' "$work/nlo" "${nobody[@]}" env -i "PATH=$path"
run 'a space and an umlaut, a German locale, another time zone' "$work/Prüfstand 7/nlo" "${nobody[@]}" \
  env -i "PATH=$path" "HOME=$work" "LOCPATH=$work/locales" LC_ALL=de_DE.UTF-8 TZ=Pacific/Chatham
exit $((failures > 0))

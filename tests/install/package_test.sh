#!/bin/sh
# SPDX-License-Identifier: MIT
# The Debian packages: their descriptions, their files, and that they can be installed into an empty root, used and
# removed.
#   usage: package_test.sh SOURCE_DIR BUILD_DIR WORK_DIR [--portable]
#   without --portable  packs the program of BUILD_DIR, which may need the processor of this machine
#   --portable          builds the target `package`: the program built again for any processor
set -eu
source=$1 build=$2 work=$3 portable=${4:-}
for program in dpkg dpkg-deb dpkg-shlibdeps file pkg-config help2man; do
  command -v $program >/dev/null || { echo "skipped: there is no $program"; exit 77; }
done
rm -rf "$work"
mkdir -p "$work/root/var/lib/dpkg/info" "$work/root/var/lib/dpkg/updates" "$work/root/var/lib/dpkg/triggers"

fail() {
  echo "FAILED: $*"
  exit 1
}
logged() { "$@" >"$work/log" 2>&1 || { cat "$work/log"; fail "$*"; }; }
# same WHAT EXPECTED FOUND: expects that two texts are equal
same() { if [ "$2" = "$3" ]; then echo "ok       $1: $2"; else fail "$1: expected \"$2\", found \"$3\""; fi; }
# wide_vectors PROGRAM: prints how many of its instructions use AVX registers
wide_vectors() { objdump -d --no-show-raw-insn "$1" | grep -cE '%[yz]mm' || true; }

if [ "$portable" ]; then
  logged cmake --build "$build" --target package
  mv "$build"/*.deb "$work"
else
  logged cpack --config "$build/CPackConfig.cmake" -B "$work" -D "CPACK_INSTALL_CMAKE_PROJECTS=$build;nlo;ALL;/" -D CPACK_INSTALL_SCRIPTS=
  rm -r "$work/_CPack_Packages"
fi
version=$(sed -n 's/^project(nlo VERSION \([0-9.]*\).*/\1/p' "$source/CMakeLists.txt")
machine=$(dpkg --print-architecture)
program=$work/nlo_${version}_$machine.deb headers=$work/libnlo-dev_${version}_all.deb
c_library=$work/libnlo-model_${version}_$machine.deb python=$work/python3-nlo_${version}_all.deb
same packages "$headers $c_library $program $python" "$(echo "$work"/*.deb)"

# Fields of the packages.
same 'the program is for' "$machine" "$(dpkg-deb -f "$program" Architecture)"
same 'the headers are for' all "$(dpkg-deb -f "$headers" Architecture)"
same 'the headers need' '' "$(dpkg-deb -f "$headers" Depends)"
needs=$(dpkg-deb -f "$program" Depends)
for library in libc6 'libfmt[0-9]+' 'libmuparser[0-9v]+' libstdc[+]+6; do
  echo "$needs" | grep -qE "(^|, )$library( |,|$)" || fail "the program needs $library, but depends only on: $needs"
done
echo "ok       the program needs $needs"
same 'the library needs' libc6 "$(dpkg-deb -f "$c_library" Depends | sed 's/ (.*//')"
same 'the Python package needs' "python3 (>= 3.9), python3-numpy, libnlo-model (= $version), nlo (= $version)" \
  "$(dpkg-deb -f "$python" Depends)"
for package in "$program" "$headers" "$c_library" "$python"; do
  dpkg-deb -f "$package" Maintainer | grep -q '^..* <.*@.*>$' || fail "$package: nobody maintains it"
  # The summary is a line of at most 80 characters; the rest is indented, so that it stays one field.
  dpkg-deb -f "$package" Description | awk 'NR == 1 ? length > 80 : !/^ [A-Za-z.]/ || length > 80 { bad = 1 } END { exit bad || NR < 3 }' ||
    fail "$package: $(dpkg-deb -f "$package" Description)"
  if dpkg-deb -c "$package" | grep -vE '^(d|-)rwxr-xr-x root/root|^-rw-r--r-- root/root|^lrwxrwxrwx root/root'; then fail "$package: owner or mode of these"; fi
done

# Install into an empty root with the package database of a system without packages.
root=$work/root
: >"$root/var/lib/dpkg/status"
# libnlo-model's script calls ldconfig, which would write the cache of this system.
mkdir "$work/bin"
printf '#!/bin/sh\n' >"$work/bin/ldconfig"
chmod +x "$work/bin/ldconfig"
in_root() {
  PATH="$work/bin:$PATH" logged dpkg --root="$root" --log="$work/dpkg.log" \
    --force-not-root,depends,bad-path,script-chrootless "$@"
}
in_root --install "$program" "$headers" "$c_library" "$python" # dpkg refuses a file that two packages have
same 'files that are not as packed' '' "$(dpkg --root="$root" --verify 2>&1)"
for package in nlo libnlo-dev libnlo-model python3-nlo; do
  cmp "$source/LICENSE" "$root/usr/share/doc/$package/copyright"
  gzip -dc "$root/usr/share/doc/$package/CHANGELOG.md.gz" | cmp - "$source/CHANGELOG.md"
  same "the changelog of $package" "nlo $version" "$(gzip -dc "$root/usr/share/doc/$package/changelog.gz" | dpkg-parsechangelog -l- | awk '/^(Source|Version):/ { printf "%s%s", n++ ? " " : "", $2 }')"
done
for name in nlo nlo-prove nlo-reproduce; do
  gzip -dc "$root/usr/share/man/man1/$name.1.gz" | grep -q '^\.TH ' || fail "$name.1 is not a manual page"
done
gzip -dc "$root/usr/share/man/man1/nlo.1.gz" | grep -q '^evaluate' || fail 'nlo.1 does not have the commands'
[ -s "$root/usr/share/nlo/experiments/van_der_pol.toml" ] || fail 'the experiments are not installed'
same 'names of the source tree' '' "$(grep -rlF "$source" "$root/usr" || true)"
for name in nlo nlo-prove nlo-reproduce; do
  same "symbols of $name" 'no symbols' "$(nm "$root/usr/bin/$name" 2>&1 | grep -o 'no symbols')"
  if [ "$portable" ] && [ "$machine" = amd64 ]; then
    same "instructions of $name that not every processor has" 0 "$(wide_vectors "$root/usr/bin/$name")"
  fi
done
if [ "$portable" ] && [ "$machine" = amd64 ]; then
  if grep -q '^NLO_NATIVE:BOOL=ON' "$build/CMakeCache.txt" && grep -qm1 '\bavx\b' /proc/cpuinfo && [ -x "$build/trainer/nlo" ]; then
    [ "$(wide_vectors "$build/trainer/nlo")" -gt 1000 ] || fail 'the native program has none either: this test sees nothing'
  fi
fi

# Use the packages: by the program, CMake and pkg-config.
same 'nlo --version' "nlo $version" "$("$root/usr/bin/nlo" --version)"
same 'nlo-prove --version' "nlo-prove $version" "$("$root/usr/bin/nlo-prove" --version)"
same 'nlo-reproduce --version' "nlo-reproduce $version" "$("$root/usr/bin/nlo-reproduce" --version)"
same 'nlo reproduce' 'Usage: nlo reproduce' "$("$root/usr/bin/nlo" reproduce --help | grep -o '^Usage: nlo reproduce')"
cp -r "$source/examples" "$work/examples"
logged cmake -G Ninja -S "$work/examples/control_loop" -B "$work/control_loop" -DCMAKE_BUILD_TYPE=Release \
  "-DCMAKE_PREFIX_PATH=$root/usr" -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF
logged cmake --build "$work/control_loop"
"$work/control_loop/control_loop" --seconds 0.2 | grep 'estimation error' || fail 'the control loop does not report'

mkdir "$work/user"
"$root/usr/bin/nlo" export "$work/examples/models/van_der_pol.json" --quiet -o "$work/user/van_der_pol.h"
cp "$(dirname "$0")/flies.cpp" "$work/user"
if g++ -std=c++20 -o "$work/user/flies" "$work/user/flies.cpp" 2>/dev/null; then fail 'it compiles without pkg-config too: this test shows nothing'; fi
export PKG_CONFIG_PATH="$root/usr/share/pkgconfig"
same 'pkg-config --modversion' "$version" "$(pkg-config --modversion nlo)"
# shellcheck disable=SC2046
g++ $(pkg-config --cflags nlo) -o "$work/user/flies" "$work/user/flies.cpp"
echo "ok       estimates $("$work/user/flies")"

# shellcheck disable=SC2046
cc -std=c99 -Wall -Werror "$source/bindings/c/estimate.c" -o "$work/user/estimate" \
  $(PKG_CONFIG_PATH=$root/usr/lib/pkgconfig pkg-config --cflags --libs nlo-model)
same 'an estimate by the C library' 2 "$(echo 0.5 | LD_LIBRARY_PATH=$root/usr/lib "$work/user/estimate" "$work/examples/models/van_der_pol.json" | wc -l)"
if /usr/bin/python3 -c 'import numpy' 2>/dev/null; then
  cp "$source/examples/models/van_der_pol.json" "$work/user/model.json"
  same 'an estimate by Python' '(1, 2)' "$(cd "$work/user" && PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=$root/usr/lib/python3/dist-packages \
    /usr/bin/python3 -c 'import nlo; print(nlo.Model.load("model.json").run([0.5]).x_hat.shape)')"
fi

in_root --purge python3-nlo nlo libnlo-dev libnlo-model
same 'files left behind' '' "$(find "$root" -path "$root/var/lib/dpkg" -prune -o -type f -print)"

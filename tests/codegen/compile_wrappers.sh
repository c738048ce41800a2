#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Folders for other frameworks around the C99 pair, as far as they can be tested without these frameworks: with shims of
# their headers they compile without warnings and give the bits of the pair, with sanitizers. A control shows that a
# difference would be detected.
#   compile_wrappers.sh EXPORT_MODEL SOURCE_DIR [all]
set -euo pipefail
export_model=$1 source=$2 shims=$2/tests/codegen/shims
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
blocks=(watched_rig:float commanded:int16) controllers=(watched_rig:float)
sensors=(watched_rig:float:angle=alpha commanded_general:double:angle=y1,velocity=x2 commanded:int16:angle=none,velocity=x1)
if [[ ${3:-} == all ]]; then
  blocks+=(rig:double gated:float) controllers+=(driven:double failing_error:float)
  sensors+=(rig:double:angle=alpha general:float:angle=y2,velocity=x1 gated:float:angle=y1,velocity=x2)
fi
warnings=(-Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror)
sanitizers=(-O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all)
fail() { echo "FAILED  $*" && exit 1; }

# options HEADER NAME: prints the macros for the shims: inputs and monitor of the pair.
options() {
  if grep -q "$2_NU" "$1"; then echo -DNLO_DRIVEN; fi
  if grep -q "$2_monitor;" "$1"; then echo -DNLO_MONITOR; fi
}

# sfunction FOLDER NAME SCALAR OUTPUT: compiles the block with the engine of the shim.
sfunction() {
  local driven=() period
  driven+=($(options "$1/$2.h" "$2"))
  period=$(sed -n 's/.*ssSetSampleTime(S, 0, \(.*\));/\1/p' "$1/$2_sfun.c")
  gcc -std=c99 "${warnings[@]}" "${sanitizers[@]}" -I"$source" -I"$shims/simulink" -I"$1" -DNLO_NAME="$2" -DNLO_SCALAR="${3/int16/float}" \
    -DNLO_PERIOD="$period" "${driven[@]}" -include "$work/$2_replay.h" "$1/$2_sfun.c" "$1/$2.c" -lm -o "$4"
}

# controller FOLDER NAME OUTPUT: compiles the controller with the manager of the shim.
controller() {
  local defined=()
  if grep -q ' u\[' "$work/$2_replay.h"; then defined+=(-DNLO_DRIVEN); fi
  if grep -q kMonitor "$1/include/$2.h"; then defined+=(-DNLO_MONITOR); fi
  g++ -std=c++20 -Wall -Wextra -Wshadow -Werror "${sanitizers[@]}" -I"$1/include" -I"$1" -I"$shims/ros2_control" -I"$work" -I"$source/runtime/include" \
    -DCONTROLLER='"src/observer_controller.cpp"' -DREPLAY="\"$2_replay.h\"" -DNLO_NAME="$2" "${defined[@]}" "$shims/ros2_control/main.cpp" -o "$3"
}

# module FOLDER NAME SCALAR OUTPUT: compiles the module with the work queue of the shim.
module() {
  local driven=()
  driven+=($(options "$1/$2.h" "$2"))
  cp "$shims/px4/readings.hpp" "$1/readings.hpp"
  gcc -std=c99 "${warnings[@]}" "${sanitizers[@]}" -c "$1/$2.c" -o "$work/pair.o"
  g++ -std=gnu++17 -Wall -Wextra -Wshadow -Werror "${sanitizers[@]}" -I"$1" -I"$shims/px4" -DNLO_NAME="$2" -DNLO_SCALAR="${3/int16/float}" \
    "${driven[@]}" -include "$work/$2_replay.h" -DMODULE="\"$1/$2_observer.cpp\"" "$shims/px4/main.cpp" "$work/pair.o" -o "$4"
}

# sensor FOLDER NAME SCALAR ROLES OUTPUT: compiles the sensor with the loop of the shim.
sensor() {
  local defined=() header=$1/src/$2_sensor.h angle=-1 velocity
  velocity=$(sed -n 's/.*x_hat_\[\(.*\)\]); }/\1/p' "$header")
  if [[ $4 != *angle=none* ]]; then angle=$2_output_$(sed 's/.*angle=\([^,]*\).*/\1/' <<<"$4"); fi
  defined+=($(options "$1/src/$2.h" "$2"))
  if grep -q 'counts its turns' "$header"; then defined+=(-DNLO_TURNS=true); else defined+=(-DNLO_TURNS=false); fi
  if grep -q 'Its time is in samples' "$header"; then defined+=(-DNLO_WHOLE_PERIODS); fi
  defined+=(-DNLO_PERIOD="$(sed -n 's/.*sampled every \([^ ]*\) s.*/\1/p' "$1/src/$2.h")" -DNLO_ANGLE="$angle" -DNLO_VELOCITY="$velocity")
  gcc -std=c99 "${warnings[@]}" "${sanitizers[@]}" -c "$1/src/$2.c" -o "$work/pair.o"
  g++ -std=gnu++11 "${warnings[@]}" "${sanitizers[@]}" -I"$1/src" -I"$shims/simplefoc" -DNLO_NAME="$2" -DNLO_SCALAR="${3/int16/float}" -DSENSOR="\"$2_sensor.h\"" \
    -DNLO_PERIOD_US="$(sed -n 's/.*kPeriod_us = \([0-9]*\)U;.*/\1/p' "$header")" "${defined[@]}" "$shims/simplefoc/main.cpp" "$work/pair.o" -o "$5"
}

# foc_sketch FOLDER NAME OUTPUT COMPILER FLAG...: compiles the example for this machine or a board.
foc_sketch() {
  local folder=$1 name=$2 output=$3
  shift 3
  "$@" -Wall -Wextra -Werror -I"$folder/src" -I"$shims/simplefoc" -I"$shims/arduino" -DSKETCH="\"$folder/examples/$name/$name.ino\"" \
    "$shims/arduino/main.cpp" -o "$output"
}

for entry in "${blocks[@]}"; do
  name=${entry%:*} scalar=${entry#*:} folder=$work/simulink_$name
  "$export_model" "$name" simulink "$scalar" "$name" "$folder"
  "$export_model" "$name" replay-c99 "$scalar" "$name" "$work/${name}_replay.h"
  sfunction "$folder" "$name" "$scalar" "$work/block"
  "$work/block" || fail "the S-function of $entry"
  for file in "${name}_sfun.c" "$name.c"; do grep -q "'$file'" "$folder/build_$name.m" || fail "build_$name.m leaves out $file"; done
  echo "ok      simulink $entry"

  "$export_model" "$name" px4 "$scalar" "$name" "$work/px4_$name"
  g++ -std=gnu++17 -Wall -Wextra -Wshadow -Werror -fsyntax-only -I"$work/px4_$name" -I"$shims/px4" "$work/px4_$name/${name}_observer.cpp"
  module "$work/px4_$name" "$name" "$scalar" "$work/queue"
  "$work/queue" >"$work/said.txt" || { cat "$work/said.txt" && fail "the module of $entry"; }
  echo "ok      px4 $entry"
done
sed -i 's/memcpy(ssGetDWork(S, kNext), &memory/memcpy(ssGetDWork(S, kNow), \&memory/' "$folder/${name}_sfun.c"
sfunction "$folder" "$name" "$scalar" "$work/block"
! "$work/block" >"$work/said.txt" || fail 'outputs that move the state went unseen'
sed -i '/_usable_outputs\(_dt\)*(/d' "$work/simulink_watched_rig/watched_rig_sfun.c" "$work/px4_watched_rig/watched_rig_observer.cpp"
sfunction "$work/simulink_watched_rig" watched_rig float "$work/block"
! "$work/block" >"$work/said.txt" || fail 'an S-function without its gate went unseen'
module "$work/px4_watched_rig" watched_rig float "$work/queue"
! "$work/queue" >"$work/said.txt" || fail 'a module without its gate went unseen'

for entry in "${controllers[@]}"; do
  name=${entry%:*} scalar=${entry#*:} folder=$work/ros2_$name
  "$export_model" "$name" ros2_control "$scalar" "$name" "$folder"
  "$export_model" "$name" replay "$scalar" "$name" "$work/${name}_replay.h"
  controller "$folder" "$name" "$work/manager"
  "$work/manager" >"$work/said.txt" || { cat "$work/said.txt" && fail "the controller of $entry"; }
  for file in package.xml plugin.xml; do python3 -c 'import sys, xml.etree.ElementTree as e; e.parse(sys.argv[1])' "$folder/$file" || fail "$file of $entry"; done
  if python3 -c 'import yaml' 2>/dev/null; then
    python3 -c 'import sys, yaml; yaml.safe_load(open(sys.argv[1]))' "$folder/config/controllers.yaml" || fail "controllers.yaml of $entry"
  fi
  echo "ok      ros2_control $entry"
done
sed -i 's/y\[j\] = read(j)/y[j] = read(0)/' "$folder/src/observer_controller.cpp"
controller "$folder" "$name" "$work/manager"
! "$work/manager" >"$work/said.txt" || fail 'a controller that reads the wrong interface went unseen'

for entry in "${sensors[@]}"; do
  IFS=: read -r name scalar roles <<<"$entry"
  folder=$work/simplefoc_$name
  "$export_model" "$name" simplefoc "$scalar,float,,$roles" "$name" "$folder"
  sensor "$folder" "$name" "$scalar" "$roles" "$work/loop"
  "$work/loop" || fail "the sensor of $entry"
  foc_sketch "$folder" "$name" "$work/sketch" g++ -std=gnu++11 -O1 "$work/pair.o" -fsanitize=address,undefined
  "$work/sketch" >"$work/said.txt" || fail "the sketch of $entry"
  [[ $(grep -cE '^-?[0-9]+\.[0-9]{4}( |$)' "$work/said.txt") -ge 1 ]] || { cat "$work/said.txt" && fail "the sketch of $entry prints nothing"; }
  for board in 'avr-g++ -std=gnu++11 -mmcu=atmega2560' 'arm-none-eabi-g++ -std=gnu++11 -mthumb -mcpu=cortex-m4 -fno-exceptions -fno-rtti'; do
    read -ra compiler <<<"$board"
    if command -v "${compiler[0]}" >/dev/null; then foc_sketch "$folder" "$name" "$work/sketch.o" "${compiler[@]}" -Os -c; fi
  done
  for key in name version author maintainer sentence paragraph category url architectures includes depends; do
    grep -qE "^$key=" "$folder/library.properties" || fail "library.properties of $entry has no $key"
  done
  python3 -c 'import sys, json; json.load(open(sys.argv[1]))' "$folder/library.json" || fail "library.json of $entry"
  echo "ok      simplefoc $entry"
done
header=$work/simplefoc_watched_rig/src/watched_rig_sensor.h
for wrong in 's/(angle_prev);  /(0);  /' 's/last_us_ += since_us/last_us_ += kPeriod_us/' 's/\(_usable_outputs_dt(.*\), y);/\1, x_hat_);/' 's/kDue_us = kPeriod_us - kSlack_us/kDue_us = 2 * kPeriod_us/'; do
  cp "$header" "$work/right.h"
  sed -i "$wrong" "$header"
  ! cmp -s "$header" "$work/right.h" || fail "the control $wrong changes nothing"
  sensor "$work/simplefoc_watched_rig" watched_rig float angle=alpha "$work/loop"
  ! "$work/loop" >"$work/said.txt" || fail "a sensor with $wrong went unseen"
  cp "$work/right.h" "$header"
done

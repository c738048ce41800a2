# SPDX-License-Identifier: MIT
# drive_of NAME SCALAR HEADER: prints the lines of C that drive.h needs for an export with this header. For bash,
# sourced.
drive_of() {
  local inputs settles
  inputs=$(sed -n "s/.* $1_NU = \([0-9]*\).*/\1/p" "$3")
  settles=$(grep "$1_warm_start" "$3" || true)
  printf '#include "%s_replay.h"\n#define NLO_NAME %s\n#define NLO_SCALAR %s\n' "$1" "$1" "$2"
  if [[ $inputs ]]; then echo "#define NLO_INPUTS $inputs"; fi
  if [[ $settles ]]; then echo '#define NLO_SETTLES'; fi
  if [[ $settles && $settles != *' u['* ]]; then echo '#define NLO_SETTLES_BY_Y'; fi
  if grep -q "$1_watch(" "$3"; then echo '#define NLO_WATCHED'; fi
  echo '#include "tests/codegen/c99/drive.h"'
}

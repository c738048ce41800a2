#!/bin/sh
# SPDX-License-Identifier: MIT
# The bound of the steady error on other plants: trains an observer of each and expects a bound within three times the
# largest error that a search finds.
#   usage: plants.sh NLO FOLDER_OF_EXPERIMENTS WORK
set -eu
nlo=$1 source=$2 work=$3
mkdir -p "$work"
for plant in pendulum reverse_duffing; do
  "$nlo" train "$source/$plant.toml" -o "$work/$plant" --force -q > "$work/$plant.log" 2>&1 || { cat "$work/$plant.log"; exit 1; }
  "$nlo" certify "$work/$plant/model.json" --noise uniform:0.05 --boxes 20000 -q --json > "$work/$plant/certificate.json"
  /usr/bin/python3 - "$work/$plant/certificate.json" <<'END'
import json, sys
rows = [r for r in json.load(open(sys.argv[1]))["rows"] if r["id"].split(".")[0] in ("steady", "map")]
assert len(rows) == 4, rows
for row in rows:
    print(row["id"], row["bound"], "proven,", row["found"], "found")
    assert row["found"] <= row["bound"] <= 3.0 * row["found"], row
END
done

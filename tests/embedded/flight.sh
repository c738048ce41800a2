#!/bin/sh
# SPDX-License-Identifier: MIT
# A model of logs, trained, exported and flown over a whole unseen log on an emulated Cortex-M4F: each estimate must be
# that of the trainer, within the tolerance that docs/appendix/embedded_counts.md states.
#   usage: flight.sh CMAKE SOURCE_DIR WORK_DIR NLO
set -eu
cmake=$1 source=$2 work=$3 nlo=$4
build=$work/build
. "$source/bench/embedded/fly_logs.sh"
rm -rf "$work" && mkdir -p "$work"
cd "$work"

logs=$source/tests/data/pendulum
"$nlo" train "$logs/pendulum.toml" --data "$logs" -o run -q --threads 1 >train.log 2>&1 ||
  { cat train.log; exit 1; }
cp run/model.json pendulum.json
"$nlo" evaluate pendulum.json --data "$logs/test.csv" --estimates log.csv >evaluate.log 2>&1 || { cat evaluate.log; exit 1; }

# Controls: one neuron whose weights are changed by a twentieth; one measurement that is changed by .01 rad.
python3 - <<END
import json
model = json.load(open("pendulum.json"))
weights = model["inverse_map"]["layers"][0]["weights"]
weights[0] = [1.05 * weight for weight in weights[0]]
json.dump(model, open("altered_weight.json", "w"))
END
build_observers "$cmake" "$nlo" "$work/pendulum.json" "$work/altered_weight.json"

failed=0
for csv in log*.csv; do # one for each part between gaps
  read -r samples ok domain instructions _ _ _ apart <<END
$(fly pendulum "$csv")
END
  echo "$csv: $samples samples, $ok ok, in_domain() agrees at $domain, estimates $apart e-9 of their RMS apart," \
    "$instructions instructions"
  [ "$samples" -eq $(($(wc -l <"$csv") - 1)) ] || { echo "FAILED  not the whole log"; failed=1; }
  agrees "$samples" "$domain" "$apart" || { echo "FAILED  the estimates are not the trainer's"; failed=1; }

  awk -F, -v OFS=, -v at=$((samples / 2)) 'NR == at { $3 += 0.01 } { print }' "$csv" >altered_sample.csv.txt
  for control in "pendulum altered_sample.csv.txt" "altered_weight $csv"; do
    read -r flown _ domain _ _ _ _ apart <<END
$(fly "${control% *}" "${control#* }")
END
    # A control that did not fly proves nothing.
    if [ "${flown:-0}" -ne "$samples" ] || agrees "$flown" "$domain" "$apart"; then
      echo "FAILED  the control: ${control% *} over ${control#* } was not detected, ${apart:-nothing} e-9"
      failed=1
    fi
  done
done
if fly pendulum "$logs/test.csv" >/dev/null 2>&1; then
  echo "FAILED  the control: another file was accepted as a flight"
  failed=1
fi
exit "$failed"

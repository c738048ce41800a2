#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""
usage: examples/rigs/battery.py CHECKOUT OUT

Writes logs of drive cycles of the LG HG2 cell from the processed files (1 Hz) of a checkout of
Battery-State-of-Charge-Estimation, with the columns of trainer/experiments/battery.toml. Charging and characterisation
tests are left out. The files are OUT/TEMPERATURE_CYCLE.csv, for example 25degC_Mixed1.csv.
"""
import re
import sys

import logs

PROCESSED = "dataset/LG_HG2_processed"
CYCLES = re.compile(r"\d+_(.*(?:Mixed|UDDS|HWFET|HWFT|LA92|US06).*)_processed\.csv")
#           ours           theirs              decimals
COLUMNS = (("time", "Time [s]", 3),
           ("voltage", "Voltage [V]", 5),
           ("current", "Current [A]", 5),  # negative when discharging
           ("temperature", "Temperature [degC]", 5),  # temperature of the cell
           ("charge", "Capacity [Ah]", 5),  # by the cycler: truth, never an output
           ("soc", "SOC [-]", 6))


def main():
    checkout, out = logs.folders(sys.argv, __doc__)
    found = 0
    for file in sorted((checkout / PROCESSED).glob("*degC/*.csv")):
        cycle = CYCLES.fullmatch(file.name)
        if cycle is None:
            continue
        theirs = logs.table(file.read_text(), [heading for _, heading, _ in COLUMNS], file)
        logs.write(out / f"{file.parent.name}_{cycle.group(1)}.csv", {name: theirs[h] for name, h, _ in COLUMNS},
                   {name: decimals for name, _, decimals in COLUMNS})
        found += 1
    if not found:
        logs.fail(f"{checkout / PROCESSED} has no drive cycle")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""
usage: examples/rigs/double_pendulum.py CHECKOUT OUT

Logs of the torque-driven double pendulum, from a checkout of double_pendulum: the system identification runs of design
C.0. The columns are those of trainer/experiments/double_pendulum.toml; nothing is computed.
"""
import sys

import logs

RECORDS = "data/experiment_records/design_C.0/20220914/sys_id"
COLUMNS = ("time", "pos_meas1", "pos_meas2", "tau_meas1", "tau_meas2")


def main():
    checkout, out = logs.folders(sys.argv, __doc__)
    files = sorted((checkout / RECORDS).glob("trajectory_*.csv"))
    if not files:
        logs.fail(f"{checkout / RECORDS} has no trajectory_*.csv")
    for file in files:
        text = file.read_text()
        rows = logs.table(text, COLUMNS, file)
        (out / file.name).write_text(text)
        print(f"{out / file.name}  {len(rows['time'])} rows")


if __name__ == "__main__":
    main()

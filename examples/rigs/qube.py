#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""
usage: examples/rigs/qube.py CHECKOUT OUT

Logs of the Quanser Qube Servo 2, from a checkout of learn_observe_KKL: takes example_csv_fin*.csv out of
Data/QQS2_data_diffx0.zip. The columns are those of trainer/experiments/qube.toml; nothing is computed.
"""
import pathlib
import sys
import zipfile

import logs

COLUMNS = ("id", "alpha", "theta", "alpha_dot", "theta_dot", "time")


def main():
    checkout, out = logs.folders(sys.argv, __doc__)
    archive = checkout / "Data/QQS2_data_diffx0.zip"
    if not archive.is_file():
        logs.fail(f"{archive} does not exist; git lfs pull may fetch it")
    found = 0
    with zipfile.ZipFile(archive) as members:
        for member in sorted(members.namelist()):
            name = pathlib.PurePosixPath(member).name
            if not (name.startswith("example_csv_fin") and name.endswith(".csv")):
                continue
            text = members.read(member).decode()
            rows = logs.table(text, COLUMNS, f"{archive}: {member}")
            (out / name).write_text(text)
            print(f"{out / name}  {len(rows['time'])} rows")
            found += 1
    if not found:
        logs.fail(f"{archive} has no example_csv_fin*.csv")


if __name__ == "__main__":
    main()

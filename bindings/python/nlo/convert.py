# SPDX-License-Identifier: MIT
"""Writes MAT-files and bags of ROS 2 as CSV logs, which `nlo new log` and [log] of an experiment read.

    python3 -m nlo.convert FILE... -o DIR

writes DIR/NAME.csv for each NAME.mat (MATLAB, -v7 or older) or NAME.db3 (rosbag2 in SQLite; a folder stands for all .db3
files in it). Columns keep their names: rig.angle, out.signals(2).values, y(2) in a MAT-file, and
/imu/linear_acceleration.x, /joint_states/position[elbow] in a bag.
"""
from __future__ import annotations

import argparse
import os
import pathlib
import sys
from typing import Mapping, Optional, Sequence, Union

from nlo import _tables
from nlo._arrays import Array
from nlo._library import Error
from nlo.bag import read_bag
from nlo.mat import read_mat


def read(path: Union[str, "os.PathLike[str]"], columns: Optional[Sequence[str]] = None, time: Optional[str] = None,
         interpolate: Optional[Mapping[str, float]] = None) -> dict[str, Array]:
    """Reads a file by read_mat or read_bag, chosen by its first bytes or its name."""
    try:
        with open(path, "rb") as file:
            head = file.read(16)
    except OSError as error:
        raise Error(f"{path}: {error.strerror}") from error
    if not head.startswith(b"MATLAB ") and pathlib.Path(path).suffix != ".mat":
        return read_bag(path, columns, time, interpolate)
    if interpolate:
        raise Error(f"{path}: --interpolate is for bags: the columns of a MAT-file have one length")
    if time is not None:
        columns = [time, *(name for name in (read_mat(path) if columns is None else columns) if name != time)]
    return read_mat(path, columns)


def _files_of(path: pathlib.Path) -> list[pathlib.Path]:
    """Returns the file, or the .db3 files of a bag's folder."""
    found = sorted(path.glob("*.db3")) if path.is_dir() else []
    return found or [path]


def _angle(text: str) -> tuple[str, float]:
    """Splits NAME or NAME=TURN into the name and the full turn of the angle."""
    name, _, turn = text.partition("=")
    return name, float(turn or 0)


def main(words: Optional[Sequence[str]] = None) -> int:
    parser = argparse.ArgumentParser(prog="python3 -m nlo.convert", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE", help="a .mat or .db3 file, or the folder of a bag")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", type=pathlib.Path, help="folder of the CSV logs")
    parser.add_argument("--column", action="append", metavar="NAME", help="write this column; may be repeated "
                        "(default: every column)")
    parser.add_argument("--time", metavar="NAME", help="the time, first column; its topic gives the rows of a bag: "
                        "/imu/header.stamp, or /imu for the time of receipt (default: of the topic with the most messages)")
    parser.add_argument("--interpolate", action="append", type=_angle, metavar="NAME[=TURN]", help="interpolate a column "
                        "of another topic, such as a reference sensor; TURN: full turn of an angle; may be repeated")
    given = parser.parse_args(words)
    files = [file for name in given.files for file in _files_of(pathlib.Path(name))]
    logs = [file.stem + ".csv" for file in files]
    try:
        for log in logs:
            if logs.count(log) > 1:
                raise Error(f"{given.output / log}: two files would be written to it: convert them to two folders")
        for file, log in zip(files, logs):
            table = read(file, given.column, given.time, dict(given.interpolate or []))
            _tables.write({log: table}, given.output)
            print(f"{given.output / log}: {len(next(iter(table.values()), ()))} rows, {len(table)} columns")
    except Error as error:
        print(f"nlo.convert: error: {error}", file=sys.stderr)
        return 1
    print(f"next: nlo new log {given.output}/*.csv")
    return 0


if __name__ == "__main__":
    sys.exit(main())

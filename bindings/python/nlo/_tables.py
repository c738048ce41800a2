# SPDX-License-Identifier: MIT
"""Experiments as dicts and logs as tables, written as the files that `nlo` reads."""
from __future__ import annotations

import csv
import difflib
import json
import math
import pathlib
from typing import Any, Iterable, Iterator, Mapping

import numpy as np

from nlo._library import Error


def nearest(name: str, known: Iterable[str]) -> str:
    """"; did you mean \"angle\"?" for the error of an unknown name; empty if no known name is similar."""
    found = difflib.get_close_matches(name, list(known), 1)
    return f"; did you mean \"{found[0]}\"?" if found else ""


def _is_table(data: Any) -> bool:
    """Returns true if `data` is a DataFrame, or a dict of one column for each name."""
    return hasattr(data, "columns") or (isinstance(data, Mapping) and bool(data) and
                                        all(np.ndim(column) == 1 for column in data.values()))


def named(data: Any) -> dict[str, Any]:
    """Returns tables by file names: a single table is log.csv, those of a list are log_1.csv, log_2.csv, ..."""
    if _is_table(data):
        return {"log.csv": data}
    if isinstance(data, Mapping):
        tables = {name if name.endswith(".csv") else name + ".csv": table for name, table in data.items()}
    else:
        tables = {f"log_{index}.csv": table for index, table in enumerate(data, 1)}
    for name, table in tables.items():
        if not _is_table(table):
            raise Error(f"data: {name} is not a table: give a DataFrame, or a dict of columns")
        if pathlib.Path(name).name != name:
            raise Error(f"data: {name} is not the name of a file")
    if not tables:
        raise Error("data: there is no table")
    return tables


def write(tables: Mapping[str, Any], folder: pathlib.Path) -> list[pathlib.Path]:
    """Writes tables as CSV with all digits. NaN becomes an empty cell."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, table in tables.items():
        columns = {str(column): np.asarray(table[column]) for column in
                   (table.columns if hasattr(table, "columns") else table)}
        if len({len(column) for column in columns.values()}) > 1:
            raise Error(f"data: the columns of {name} differ in length")
        with open(folder / name, "w", newline="", encoding="utf-8") as file:
            rows = csv.writer(file, lineterminator="\n")
            rows.writerow(columns)
            rows.writerows(zip(*[[_cell(value) for value in column.tolist()] for column in columns.values()]))
    return [folder / name for name in tables]


def _cell(value: Any) -> str:
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return ""
    return repr(value) if isinstance(value, float) else str(int(value) if isinstance(value, bool) else value)


def with_files(experiment: Mapping[str, Any], tables: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the experiment with train_files and test_files added to [log], unless it names files."""
    log = dict(experiment.get("log", {}))
    if "train_files" not in log:
        log["train_files"] = [name for name in tables if not name.startswith("test")]
        tests = [name for name in tables if name.startswith("test")]
        if tests:
            log.setdefault("test_files", tests)
    return {**experiment, "log": log}


def toml(keys: Mapping[str, Any]) -> str:
    """Writes nested dicts as TOML: values first, then tables."""
    return "\n".join(_lines(keys, "")) + "\n"


def _lines(keys: Mapping[str, Any], path: str) -> Iterator[str]:
    tables = {}
    for key, value in keys.items():
        if isinstance(value, Mapping) or (isinstance(value, (list, tuple)) and value and
                                          all(isinstance(each, Mapping) for each in value)):
            tables[key] = value
        elif value is not None:
            yield f"{_key(key)} = {_value(value)}"
    for key, value in tables.items():
        name = path + _key(key)
        for each in [value] if isinstance(value, Mapping) else value:
            yield f"\n[{name}]" if isinstance(value, Mapping) else f"\n[[{name}]]"
            yield from _lines(each, name + ".")


def _key(key: str) -> str:
    return key if key and all(c.isascii() and (c.isalnum() or c in "_-") for c in key) else json.dumps(key)


def _value(value: Any) -> str:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, str)):
        return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else str(value)
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else ("nan" if math.isnan(value) else "inf" if value > 0 else "-inf")
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(key)} = {_value(each)}" for key, each in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(each) for each in value) + "]"
    raise Error(f"experiment: {value!r} is not a value of an experiment")

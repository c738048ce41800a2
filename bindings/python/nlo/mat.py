# SPDX-License-Identifier: MIT
"""Reads MAT-files as tables. scipy reads the file; this module finds the vectors in it.

A column has the name that it has in MATLAB: "angle", "rig.angle", "out.signals(2).values", or "y(2)" for the second column
of a matrix. Elements count from 1, as in MATLAB.
"""
from __future__ import annotations

import collections
import os
import pathlib
import re
from typing import Any, Iterator, Mapping, NoReturn, Optional, Sequence, Union

import numpy as np

from nlo._arrays import Array
from nlo._library import Error
from nlo._tables import nearest

_MOST_COLUMNS = 32  # if no column is named: largest matrix width, and largest number of structs, that are read
_STEP = re.compile(r"([^.()]+)(?:\(([1-9]\d*)\))?")


def read_mat(path: Union[str, "os.PathLike[str]"], columns: Optional[Sequence[str]] = None) -> dict[str, Array]:
    """Reads vectors of a MAT-file (-v7 or older) as columns of a table.

    columns   names, as above; None: every vector of the length that most vectors have

    All columns have the same length. Raises nlo.Error if a column does not exist, is not a vector of real numbers, or
    differs in length, and if the file is damaged.
    """
    file = _File(path)
    table: dict[str, Array] = {}
    for name in file.vectors() if columns is None else columns:
        table[name] = file.column(name, len(next(iter(table.values()))) if table else 0)
    return table


class _File:
    def __init__(self, path: Union[str, "os.PathLike[str]"]) -> None:
        self._path = os.fspath(path)
        try:
            from scipy.io import loadmat
        except ImportError as error:
            raise Error(f"{self._path}: reading a MAT-file needs scipy: install the Debian package python3-scipy, or "
                        "pip install scipy") from error
        data = pathlib.Path(path).read_bytes()
        if b"MATLAB 7.3 MAT-file" in data[:32]:
            self._fail("is a MAT-file of version 7.3: save it with save(..., \"-v7\")")
        if needed := _length(data):
            self._fail(f"has {len(data)} bytes and needs {needed}: it was not copied whole, or is still written")
        try:
            found = loadmat(self._path, appendmat=False)
        except Exception as error:  # any kind, because scipy has one for each fault of a file
            raise Error(f"{self._path}: is damaged, or not a MAT-file: {error}") from error
        self._variables = {name: value for name, value in found.items() if not name.startswith("__")}

    def vectors(self) -> list[str]:
        """Returns the names of all vectors that have the most frequent length."""
        found = [each for name, value in self._variables.items() for each in _vectors(name, value)]
        if not found:
            self._fail("has no vector of numbers, also not in its structs: expected a log")
        most = collections.Counter(length for _, length in found).most_common(1)[0][0]
        return [name for name, length in found if length == most]

    def column(self, name: str, samples: int) -> Array:
        """Returns the vector `name`. `samples`: its required length; 0: any."""
        value, of_matrix = self._find(name)
        matrix = self._numbers(name, value)
        size = f"{matrix.shape[0]} x {matrix.shape[1]}"
        if of_matrix == 0 and min(matrix.shape) != 1:
            self._fail(f"{name} is {size}: write {name}(1) for its first column")
        samples = samples or max(matrix.shape)
        if samples not in matrix.shape:
            self._fail(f"{name} is {size}, and the log has {samples} samples: take signals of one clock, or resample")
        if matrix.shape[0] != samples:  # a sample is a column of the matrix
            matrix = matrix.T
        if of_matrix > matrix.shape[1]:
            self._fail(f"{name} is {size}: it has no column ({of_matrix})")
        return np.ascontiguousarray(matrix[:, max(of_matrix, 1) - 1])

    def _find(self, name: str) -> tuple[Any, int]:
        """Returns the value at the path `name`, and the number of the named column of this matrix; 0: none is named."""
        steps = [_STEP.fullmatch(part) for part in name.split(".")]
        if not all(steps):
            self._fail(f"\"{name}\" does not name a variable: write y, rig.angle, out.signals(2).values or y(1)")
        names = [step[1] for step in steps if step]
        places = [int(step[2] or 0) for step in steps if step]
        if names[0] not in self._variables:
            self._fail_unknown(f"variable \"{names[0]}\"", names[0], self._variables)
        value, above = self._variables[names[0]], names[0]
        for place, field in zip(places, names[1:]):
            if not isinstance(value, np.ndarray) or value.dtype.names is None:
                self._fail(f"{above} is not a struct: it has no field {field}")
            if field not in value.dtype.names:
                self._fail_unknown(f"field \"{field}\" of {above}", field, value.dtype.names)
            if max(place, 1) > value.size or (place == 0 and value.size > 1):
                self._fail(f"{above} is {value.size} structs: write {above}(1).{field} to {above}({value.size}).{field}")
            value, above = value[field].flat[max(place, 1) - 1], f"{above}.{field}"
        return value, places[-1]

    def _numbers(self, name: str, value: Any) -> Array:
        """Returns `value` as a matrix of double."""
        def refuse(what: str) -> NoReturn:
            self._fail(f"{name} is {what}: expected a vector of numbers")

        if not isinstance(value, np.ndarray):
            refuse("sparse: save full(...) of it" if hasattr(value, "todense") else "not a number")
        if type(value) is not np.ndarray or (value.dtype.names and "_ObjectMetadata" in value.dtype.names):
            refuse("an object (a timeseries or a table?): save its parts, as t = ts.Time; y = ts.Data")
        if value.dtype.kind == "U":
            refuse("text")
        if value.dtype == object:
            refuse("a cell array")
        if value.dtype.kind == "c":
            refuse("complex: save real(...) and imag(...) of it")
        if value.dtype.kind not in "fiub":
            refuse("not a number")
        if value.ndim != 2:
            refuse("of more than two dimensions")
        return value.astype(float)

    def _fail(self, what: str) -> NoReturn:
        raise Error(f"{self._path}: {what}")

    def _fail_unknown(self, what: str, name: str, known: Union[Sequence[str], Mapping[str, Any]]) -> NoReturn:
        self._fail(f"no {what} among {', '.join(known) or 'none'}{nearest(name, known)}")


def _vectors(name: str, value: Any) -> Iterator[tuple[str, int]]:
    """Yields (name, length) of each vector in `value`."""
    if type(value) is not np.ndarray:
        return
    if value.dtype.names is not None:
        for i, struct in enumerate(value.flat[:_MOST_COLUMNS], 1):
            place = f"({i})" if value.size > 1 else ""
            for field in value.dtype.names:
                yield from _vectors(f"{name}{place}.{field}", struct[field])
    elif value.dtype.kind in "fiub" and value.ndim == 2 and max(value.shape) > 1 and 0 < min(value.shape) <= _MOST_COLUMNS:
        for i in range(1, min(value.shape) + 1):
            yield (f"{name}({i})" if min(value.shape) > 1 else name), max(value.shape)


def _length(data: bytes) -> int:
    """Returns the length by the variables' tags if `data` is shorter, else 0. scipy reads some such files."""
    order = "little" if data[126:128] == b"IM" else "big"
    if len(data) < 128 or int.from_bytes(data[124:126], order) != 0x100:
        return 0
    at = 128
    while at < len(data):
        at += 8 + int.from_bytes(data[at + 4:at + 8], order)
    return at if at > len(data) else 0

# SPDX-License-Identifier: MIT
"""Channels, and the arrays of a user as libnlo-model takes them."""
from __future__ import annotations

import dataclasses
from typing import Any, Mapping, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from nlo import _library as lib
from nlo._library import Error

Array = npt.NDArray[np.float64]
#: Numbers for channels: an array (samples x channels; samples alone for one channel), or names with a column each,
#: such as a pandas DataFrame.
Columns = Union[npt.ArrayLike, Mapping[str, Any]]
_PRECISIONS = {"float": lib.FLOAT, "double": lib.DOUBLE}


@dataclasses.dataclass(frozen=True)
class Channel:
    """An output, an input or a state."""

    name: str
    unit: str    #: "" where none is known
    turn: float  #: the full turn of an angle in its unit; 0: not an angle
    low: float   #: declared range; outside it a measurement is clamped, but not an angle or a relative output
    high: float


def precision_of(name: str) -> int:
    if name not in _PRECISIONS:
        raise Error(f'precision "{name}": it is "float" or "double"')
    return _PRECISIONS[name]


def address(array: Optional[npt.NDArray[Any]]) -> Optional[int]:
    return None if array is None else array.ctypes.data


def samples(given: Columns, channels: Sequence[Channel], what: str) -> Array:
    """As N x channels, C order."""
    names = [channel.name for channel in channels]
    if hasattr(given, "columns") or isinstance(given, Mapping):
        missing = [name for name in names if name not in given]  # type: ignore[operator]
        if missing:
            raise Error(f"{what}: there is no column {', '.join(missing)}")
        columns: Any = given
        table = np.column_stack([np.asarray(columns[name], dtype=float) for name in names])
    else:
        table = np.asarray(given, dtype=float)
        if table.ndim == 1 and len(names) == 1:
            table = table[:, np.newaxis]
    if table.ndim != 2 or table.shape[1] != len(names):
        raise Error(f"{what} has the shape {table.shape}: it must be samples x {len(names)} ({', '.join(names)})")
    return np.ascontiguousarray(table)

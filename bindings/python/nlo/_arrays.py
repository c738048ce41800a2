# SPDX-License-Identifier: MIT
"""Channels, and the conversion of a user's arrays into arrays for libnlo-model."""
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
    unit: str    #: "" if it is not known
    turn: float  #: the full turn of an angle in its unit; 0: not an angle
    low: float   #: declared range, outside of which a measurement is clamped (but not an angle or a relative output)
    high: float


def precision_of(name: str) -> int:
    if not isinstance(name, str) or name not in _PRECISIONS:
        raise Error(f'precision "{name}": it is "float" or "double"')
    return _PRECISIONS[name]


def address(array: Optional[npt.NDArray[Any]]) -> Optional[int]:
    return None if array is None else array.ctypes.data


def numbers(given: Any, what: str) -> Array:
    """Converts to floats. Masked values, None and pandas' NA become NaN, a missing sample. TypeError names `what`."""
    if isinstance(given, np.ma.MaskedArray):
        return np.asarray(given.astype(float).filled(np.nan))
    if hasattr(given, "to_numpy"):  # a Series of pandas, whose missing values numpy does not read
        given = given.to_numpy(dtype=float, na_value=np.nan)
    try:
        return np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        pass
    try:
        objects = np.asarray(given, dtype=object)
        if any(isinstance(value, (str, bytes)) for value in objects.flat):
            raise TypeError("text")
        values = [np.nan if value is None or type(value).__name__ in ("NAType", "MaskedConstant") else float(value)
                  for value in objects.flat]
    except (TypeError, ValueError):
        raise TypeError(f"{what} must be numbers, NaN where a sample is missing; it is {type(given).__name__}: "
                        f"{str(given)[:60]}") from None
    return np.array(values).reshape(objects.shape)


def samples(given: Columns, channels: Sequence[Channel], what: str) -> Array:
    """Converts to an array of N x channels in C order."""
    names = [channel.name for channel in channels]
    if hasattr(given, "columns") or isinstance(given, Mapping):
        missing = [name for name in names if name not in given]  # type: ignore[operator]
        if missing:
            raise Error(f"{what}: there is no column {', '.join(missing)}")
        columns: Any = given
        table = np.column_stack([numbers(columns[name], f"{what}, column {name}") for name in names])
    else:
        table = numbers(given, what)
        if table.ndim == 1 and len(names) == 1:
            table = table[:, np.newaxis]
    if table.ndim != 2 or table.shape[1] != len(names):
        raise Error(f"{what} has the shape {table.shape}: it must be samples x {len(names)} ({', '.join(names)})")
    return np.ascontiguousarray(table)

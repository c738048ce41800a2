# SPDX-License-Identifier: MIT
"""Declares libnlo-model for ctypes (bindings/c/nlo_model.h). ctypes lets other threads run during each call."""
from __future__ import annotations

import ctypes
import enum
import os
import pathlib

package = pathlib.Path(__file__).resolve().parent  #: PREFIX/lib/python3/dist-packages/nlo, where it is not of a wheel
ABI = 2
FLOAT, DOUBLE = 32, 64
OUTPUT, INPUT, STATE = 0, 1, 2
NOT_KNOWN = -4


class Error(Exception):
    """Raised if nlo refuses an input or fails. The text names the file, the field or line, and the remedy."""


class Status(enum.IntEnum):
    """How a step used its measurement. A larger value is worse. The latent state is finite after every step."""

    OK = 0            #: the measurement was used unchanged
    CLAMPED = 1       #: an output or input outside its declared range was clamped to it
    HELD = 2          #: an output was missing, not finite, or an angle out of range: its last good value was used
    STALE = 3         #: an output or input was held for about a time constant: do not trust the estimates
    OUT_OF_RANGE = 4  #: an output or input was out of range for about a time constant: do not trust the estimates
    REJECTED = 5      #: the time step was not positive, or longer than the model can span: the step changed nothing
    DIVERGED = 6      #: the step would have overflowed: the last z was kept
    RESET = 7         #: a bit flip corrupted the state; only exported observers return this


def _found() -> str:
    """Returns the path of the library: from NLO_MODEL_LIBRARY, else in the wheel, in the same prefix, or the system's."""
    name = f"libnlo-model.so.{ABI}"
    if given := os.environ.get("NLO_MODEL_LIBRARY"):
        return given
    beside = [package / "lib" / name, *(above / name for above in package.parents[2:3])]
    return next((str(path) for path in beside if path.exists()), name)


def _loaded() -> ctypes.CDLL:
    try:
        library = ctypes.CDLL(_found())
    except OSError as error:
        raise ImportError(f"{error}: install libnlo-model, or name it in NLO_MODEL_LIBRARY") from error
    text, real, whole, pointer, size = ctypes.c_char_p, ctypes.c_double, ctypes.c_int, ctypes.c_void_p, ctypes.c_size_t
    results = {text: ["version", "last_error", "model_name", "model_structure", "model_channel_name",
                      "model_channel_unit", "model_json"],
               real: ["model_sample_period_s", "model_channel_turn"],
               pointer: ["model_from_bytes", "observer_create", "observer_copy"],
               None: ["model_free", "observer_free"]}
    arguments = {"version": [], "last_error": [], "abi_version": [], "model_from_bytes": [text, size],
                 "model_channel_name": [pointer, whole, whole], "model_channel_unit": [pointer, whole, whole],
                 "model_channel_turn": [pointer, whole, whole],
                 "model_channel_range": [pointer, whole, whole, pointer, pointer],
                 "model_linear_latent": [pointer, pointer, pointer],
                 "model_inverse_map": [pointer, whole, size, pointer, pointer, pointer],
                 "model_run": [pointer, whole, size, *[pointer] * 8],
                 "observer_create": [pointer, whole], "observer_step": [pointer, pointer, pointer],
                 "observer_step_dt": [pointer, pointer, pointer, real], "observer_estimate": [pointer, pointer],
                 "observer_estimate_with_error": [pointer, pointer, pointer], "observer_latent": [pointer, pointer],
                 "observer_save": [pointer, pointer], "observer_restore": [pointer, pointer, size]}
    of_pointer = ["model_free", "model_name", "model_structure", "model_sample_period_s", "model_ny", "model_nu",
                  "model_nx", "model_nz", "model_nr", "model_has_sigma", "model_json", "observer_copy", "observer_free",
                  "observer_reset", "observer_status", "observer_in_domain", "observer_state_size"]
    for name, types in {**arguments, **dict.fromkeys(of_pointer, [pointer])}.items():
        getattr(library, "nlo_" + name).argtypes = types
    for result, names in results.items():
        for name in names:
            getattr(library, "nlo_" + name).restype = result
    if library.nlo_abi_version() != ABI:
        raise ImportError(f"{_found()} has interface {library.nlo_abi_version()}, this package uses {ABI}: update both")
    return library


library = _loaded()
__version__: str = library.nlo_version().decode()


def text(value: bytes) -> str:
    return value.decode("utf-8", "replace")


def last_error() -> Error:
    return Error(text(library.nlo_last_error()))


def checked(code: int) -> int:
    """Returns the result of a library call. Raises Error with the library's text if it is negative."""
    if code < 0:
        raise last_error()
    return code

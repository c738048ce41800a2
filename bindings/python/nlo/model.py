# SPDX-License-Identifier: MIT
"""Models, observers and runs over arrays."""
from __future__ import annotations

import ctypes
import dataclasses
import json
import os
import pathlib
from typing import Any, Iterator, Mapping, Optional, Union

import numpy as np
import numpy.typing as npt

from nlo import _library as lib
from nlo._arrays import Array, Channel, Columns, address, numbers, precision_of, samples
from nlo._library import Error, checked, library
from nlo.observer import Observer

@dataclasses.dataclass(frozen=True)
class Run:
    """The results of an observer over N samples."""

    t: Array                    #: N, seconds
    x_hat: Array                #: N x n_x, estimates
    sigma: Optional[Array]      #: N x n_x, standard deviations of the errors; None if the model does not have them
    z: Array                    #: N x n_z, latent states
    status: npt.NDArray[np.int32]     #: N, see Status
    in_domain: npt.NDArray[np.bool_]  #: N, true if z is in the domain of the training
    states: tuple[Channel, ...]

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        names = ", ".join(state.name for state in self.states)
        span = f" over {self.t[-1] - self.t[0]:.4g} s" if len(self) > 1 else ""
        if not len(self):
            return f"<nlo.Run of no samples: {names}>"
        worst = lib.Status(int(self.status.max())).name
        return (f"<nlo.Run of {len(self)} samples{span}: {names}; {np.mean(self.in_domain):.1%} in the domain, "
                f"worst status {worst}>")

    def __getitem__(self, state: str) -> Array:
        """The estimates of one state, by its name."""
        for index, channel in enumerate(self.states):
            if channel.name == state:
                return self.x_hat[:, index]
        raise KeyError(f"{state}: the states are {', '.join(channel.name for channel in self.states)}")


class Model:
    """A trained observer, which never changes. Threads can share a model, and it can be pickled."""

    def __init__(self, data: bytes) -> None:
        """Makes a model from the bytes of a model file and checks every field. Model.load() reads a file."""
        if not isinstance(data, (bytes, bytearray)):
            raise TypeError(f"data must be the bytes of a model file; it is {type(data).__name__}: Model.load() takes a path")
        data = bytes(data)
        self._free = library.nlo_model_free
        self._handle = library.nlo_model_from_bytes(data, len(data))
        if not self._handle:
            raise lib.last_error()
        get = library
        self.name: str = lib.text(get.nlo_model_name(self._handle))
        self.structure: str = lib.text(get.nlo_model_structure(self._handle))  #: "kkl", "gated", ...
        self.sample_period_s: float = get.nlo_model_sample_period_s(self._handle)
        self.outputs = self._channels(lib.OUTPUT, get.nlo_model_ny(self._handle))  #: the outputs y that step() takes
        self.inputs = self._channels(lib.INPUT, get.nlo_model_nu(self._handle))
        self.states = self._channels(lib.STATE, get.nlo_model_nx(self._handle))
        self.n_z: int = get.nlo_model_nz(self._handle)  #: latent states
        #: number of readings of T* and F: outputs, then inputs, then the staleness of each output that may fail
        self.n_readings: int = get.nlo_model_nr(self._handle)
        self.has_sigma: bool = bool(get.nlo_model_has_sigma(self._handle))

    @classmethod
    def load(cls, path: Union[str, os.PathLike[str]]) -> Model:
        """Reads a model file. Raises Error with the text `FILE:LINE: FIELD: reason and remedy`."""
        try:
            data = pathlib.Path(path).read_bytes()
        except OSError as error:
            raise Error(f"{os.fspath(path)}: {error.strerror}") from error
        try:
            return cls(data)
        except Error as error:
            raise Error(str(error).replace("model", os.fspath(path), 1)) from None

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes a model file in the format of this version of nlo."""
        pathlib.Path(path).write_text(self.json, encoding="utf-8")

    def __del__(self) -> None:
        if getattr(self, "_handle", None):
            self._free(self._handle)

    def __copy__(self) -> Model:
        return self  # it never changes

    def __deepcopy__(self, _: dict[int, object]) -> Model:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return Model, (self.json.encode(),)

    def __repr__(self) -> str:
        names = ", ".join(f"{s.name} [{s.unit}]" if s.unit else s.name for s in self.states)
        return f"<nlo.Model {self.name}: {self.structure}, {self.sample_period_s} s, estimates {names}>"

    @property
    def json(self) -> str:
        """The text of the model file."""
        return lib.text(library.nlo_model_json(self._handle))

    @property
    def fields(self) -> dict[str, Any]:
        """The model file as a dict; to change one, build Model(json.dumps(fields).encode())."""
        fields: dict[str, Any] = json.loads(self.json)
        return fields

    @property
    def provenance(self) -> dict[str, str]:
        """Facts about the training: version, seed, experiment, hash of the data, errors."""
        return dict(self.fields["provenance"])

    @property
    def D(self) -> Array:
        """D of dz/dt = D z + F y, n_z x n_z. Raises Error if the latent system of the model is not linear."""
        return self._linear_latent()[0]

    @property
    def F(self) -> Array:
        """F of dz/dt = D z + F y, n_z x n_readings. Raises Error if the latent system of the model is not linear."""
        return self._linear_latent()[1]

    @property
    def eigenvalues(self) -> npt.NDArray[np.complex128]:
        """The eigenvalues of D [1/s]."""
        return np.linalg.eigvals(self.D).astype(complex)

    def inverse_map(self, z: npt.ArrayLike, readings: Optional[npt.ArrayLike] = None,
                    precision: str = "double") -> Array:
        """Returns the estimates T*(z), N x n_x, of latent states z, N x n_z.

        readings  N x n_readings; needed only if T* reads them, too
        """
        latent = np.ascontiguousarray(np.atleast_2d(numbers(z, "z")))
        if latent.ndim != 2 or latent.shape[1] != self.n_z:
            raise Error(f"z has the shape {latent.shape}: it must be samples x {self.n_z}")
        read = None
        if readings is not None:
            read = np.ascontiguousarray(np.atleast_2d(numbers(readings, "readings")))
            if read.shape != (len(latent), self.n_readings):
                raise Error(f"readings have the shape {read.shape}: it must be {len(latent)} x {self.n_readings}")
        x_hat = np.empty((len(latent), len(self.states)))
        checked(library.nlo_model_inverse_map(self._handle, precision_of(precision), len(latent), address(latent),
                                              address(read), address(x_hat)))
        return x_hat

    def observer(self, precision: str = "float") -> Observer:
        """Returns a new observer before its first sample. "float" gives the estimates that nlo evaluate tests."""
        return Observer(self, precision)

    def run(self, y: Columns, u: Optional[Columns] = None, t: Optional[npt.ArrayLike] = None,
            precision: str = "float") -> Run:
        """Runs a new observer over N samples and returns its results.

        y  N x n_y outputs, or a DataFrame with columns of their names; angles as the sensor gives them, NaN: missing
        u  N x n_u known inputs, if the model has inputs; None: the columns of y with their names
        t  N time stamps in seconds; None: each step is one sample period
        """
        if self.inputs and u is None and (hasattr(y, "columns") or isinstance(y, Mapping)):
            u = y
        outputs = samples(y, self.outputs, "y")
        n = len(outputs)
        inputs = samples(u, self.inputs, "u") if self.inputs and u is not None else None
        stamps = None if t is None else np.ascontiguousarray(numbers(t, "t"))
        if self.inputs and inputs is None:
            raise Error(f"u is missing: {self.name} reads {', '.join(channel.name for channel in self.inputs)}")
        if u is not None and not self.inputs:
            raise Error(f"{self.name} has no inputs: leave u out")
        for what, array in (("u", inputs), ("t", stamps)):
            if array is not None and len(array) != n:
                raise Error(f"{what} has {len(array)} samples, y has {n}")
        if stamps is not None and stamps.ndim != 1:
            raise Error(f"t has the shape {stamps.shape}: it must be one time for each sample")
        x_hat, z = np.empty((n, len(self.states))), np.empty((n, self.n_z))
        sigma = np.empty((n, len(self.states))) if self.has_sigma else None
        status, in_domain = np.empty(n, dtype=np.int32), np.empty(n, dtype=np.uint8)
        checked(library.nlo_model_run(self._handle, precision_of(precision), n, address(outputs), address(inputs),
                                      address(stamps), address(x_hat), address(sigma), address(z),
                                      address(status), address(in_domain)))
        times = np.arange(n) * self.sample_period_s if stamps is None else stamps
        return Run(times, x_hat, sigma, z, status, in_domain.astype(bool), self.states)

    def with_map(self, layers: Any, **how: Any) -> Model:
        """Returns the same observer with a T* that was trained elsewhere: see nlo.weights.with_map."""
        from nlo.weights import with_map

        return with_map(self, layers, **how)

    def _linear_latent(self) -> tuple[Array, Array]:
        d, f = np.empty((self.n_z, self.n_z)), np.empty((self.n_z, self.n_readings))
        checked(library.nlo_model_linear_latent(self._handle, address(d), address(f)))
        return d, f

    def _channels(self, kind: int, count: int) -> tuple[Channel, ...]:
        def each() -> Iterator[Channel]:
            low, high = ctypes.c_double(), ctypes.c_double()
            for index in range(count):
                checked(library.nlo_model_channel_range(self._handle, kind, index, ctypes.addressof(low),
                                                        ctypes.addressof(high)))
                yield Channel(lib.text(library.nlo_model_channel_name(self._handle, kind, index)),
                              lib.text(library.nlo_model_channel_unit(self._handle, kind, index)),
                              library.nlo_model_channel_turn(self._handle, kind, index), low.value, high.value)

        return tuple(each())

# SPDX-License-Identifier: MIT
"""Observers that run sample by sample."""
from __future__ import annotations

from typing import TYPE_CHECKING, Optional

import numpy as np
import numpy.typing as npt

from nlo import _library as lib
from nlo._arrays import Array, address, numbers, precision_of
from nlo._library import Error, Status, checked, library

if TYPE_CHECKING:
    from nlo.model import Model


class Observer:
    """Runs an observer sample by sample. Only one thread may use it at a time; copies are independent."""

    def __init__(self, model: Model, precision: str = "float") -> None:
        self._start(model, precision, library.nlo_observer_create(model._handle, precision_of(precision)))

    def _start(self, model: Model, precision: str, handle: Optional[int]) -> None:
        self._free = library.nlo_observer_free
        self._handle = handle
        if not handle:
            raise lib.last_error()
        self.model, self.precision = model, precision
        self._y, self._u = np.zeros(len(model.outputs)), np.zeros(len(model.inputs))
        self._y_at, self._u_at = address(self._y), address(self._u)

    def __del__(self) -> None:
        if getattr(self, "_handle", None):
            self._free(self._handle)

    def step(self, y: npt.ArrayLike, u: Optional[npt.ArrayLike] = None, dt: Optional[float] = None) -> Status:
        """Steps by one sample and returns its status.

        y   n_y outputs; NaN: missing
        u   n_u inputs, if the model has inputs
        dt  time since the last sample [s]; None: one sample period
        """
        self._take(y, self._y, "y")
        if u is not None or self.model.inputs:
            self._take([] if u is None else u, self._u, "u")
        if dt is None:
            code = library.nlo_observer_step(self._handle, self._y_at, self._u_at)
        else:
            step = numbers(dt, "dt")
            if step.size != 1:
                raise TypeError(f"dt must be one number of seconds; it has {step.size}")
            code = library.nlo_observer_step_dt(self._handle, self._y_at, self._u_at, float(step.reshape(())))
        return Status(checked(code))

    def estimate(self) -> Array:
        """Returns the estimate x_hat, n_x."""
        x_hat = np.empty(len(self.model.states))
        checked(library.nlo_observer_estimate(self._handle, address(x_hat)))
        return x_hat

    def estimate_with_error(self) -> tuple[Array, Array]:
        """Returns x_hat and the standard deviations of its errors; 2**100: unknown. The model must have has_sigma."""
        x_hat, sigma = np.empty(len(self.model.states)), np.empty(len(self.model.states))
        checked(library.nlo_observer_estimate_with_error(self._handle, address(x_hat), address(sigma)))
        return x_hat, sigma

    @property
    def latent(self) -> Array:
        """The latent state z, n_z."""
        z = np.empty(self.model.n_z)
        checked(library.nlo_observer_latent(self._handle, address(z)))
        return z

    @property
    def status(self) -> Status:
        """The status of the last step."""
        return Status(checked(library.nlo_observer_status(self._handle)))

    @property
    def in_domain(self) -> bool:
        """True if z is within the domain of the training."""
        return bool(checked(library.nlo_observer_in_domain(self._handle)))

    def reset(self) -> None:
        """Forgets everything: the next sample is the first."""
        checked(library.nlo_observer_reset(self._handle))

    def copy(self) -> Observer:
        """Returns an independent observer that continues from the present state."""
        other = Observer.__new__(Observer)
        other._start(self.model, self.precision, library.nlo_observer_copy(self._handle))
        return other

    __copy__ = copy

    def __deepcopy__(self, _: dict[int, object]) -> Observer:
        return self.copy()

    def __reduce__(self) -> tuple[object, ...]:
        return _restored, (self.model, self.precision, self.save())

    def __repr__(self) -> str:
        estimate = ", ".join(f"{state.name} {value:.4g}" for state, value in zip(self.model.states, self.estimate()))
        return f"<nlo.Observer of {self.model.name}: {self.status.name}, {estimate}>"

    def save(self) -> Array:
        """Returns the state of the observer as numbers, for restore()."""
        state = np.empty(checked(library.nlo_observer_state_size(self._handle)))
        checked(library.nlo_observer_save(self._handle, address(state)))
        return state

    def restore(self, state: npt.ArrayLike) -> None:
        """Continues from a saved state of the same model and precision, with the same bits."""
        given = np.ascontiguousarray(numbers(state, "state"))
        checked(library.nlo_observer_restore(self._handle, address(given), given.size))

    @staticmethod
    def _take(given: npt.ArrayLike, to: Array, what: str) -> None:
        values = numbers(given, what).reshape(-1)
        if values.size != to.size:
            raise Error(f"{what} has {values.size} numbers: the model takes {to.size}")
        to[:] = values


def _restored(model: Model, precision: str, state: Array) -> Observer:
    observer = Observer(model, precision)
    observer.restore(state)
    return observer

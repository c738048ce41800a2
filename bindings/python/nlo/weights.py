# SPDX-License-Identifier: MIT
"""Puts a T* that was trained elsewhere into a model."""
from __future__ import annotations

import json
from typing import Any, Mapping, Optional, Sequence

import numpy as np
import numpy.typing as npt

from nlo._arrays import Array
from nlo._library import Error
from nlo.model import Model


def with_map(model: Model, layers: Any, activation: str = "tanh", normalised: bool = False,
             input_mean: Optional[npt.ArrayLike] = None, input_scale: Optional[npt.ArrayLike] = None,
             output_mean: Optional[npt.ArrayLike] = None, output_scale: Optional[npt.ArrayLike] = None) -> Model:
    """Returns the same observer with another T*: a network of layers W u + b.

    layers      pairs (W n_out x n_in, b n_out), first layer first; or the state_dict of a PyTorch MLP: names that end
                in "weight" and "bias", in order
    activation  after each layer except the last: "tanh", "relu" or "silu"
    normalised  true: the network reads the normalised features of the model's own T* and returns normalised states.
                false: it reads (v - input_mean) / input_scale, where v is z (n_z) or z and the readings
                (n_z + n_readings), and the estimate is its result times output_scale plus output_mean

    Raises Error if the layers do not fit, or if the reader of model files refuses the new model. The monitor and the
    error head are left out, because they were fitted to the old T*.
    """
    fields = model.fields
    if "inverse_map" not in fields:
        raise Error(f"{model.name} ({model.structure}) has no T*: z is its estimate")
    weights = _pairs(layers)
    old, nx = fields["inverse_map"], len(model.states)
    if normalised:
        features = np.atleast_2d(np.asarray(old["features"], dtype=float))
        if any(each is not None for each in (input_mean, input_scale, output_mean, output_scale)):
            raise Error("normalised: the model has the means and scales; leave them out")
    else:
        features = _identity(weights[0][0].shape[1], model.n_z, _inputs(old))
    reads = len(features)
    _check_chain(weights, reads, nx)
    clocks = old.get("feature_clocks") if normalised else None
    network: dict[str, Any] = {
        "features": features.tolist(),
        "feature_mean": old["feature_mean"] if normalised else _numbers(input_mean, reads, 0.0, "input_mean"),
        "feature_scale": old["feature_scale"] if normalised else _numbers(input_scale, reads, 1.0, "input_scale"),
        **({"feature_clocks": clocks} if clocks else {}),
        "activation": activation,
        "layers": [{"weights": w.tolist(), "bias": b.tolist()} for w, b in weights],
        "skip": [],
        "output_mean": old["output_mean"] if normalised else _numbers(output_mean, nx, 0.0, "output_mean"),
        "output_scale": old["output_scale"] if normalised else _numbers(output_scale, nx, 1.0, "output_scale"),
    }
    fields["inverse_map"] = network
    for fitted in ("monitor", "error"):
        fields.pop(fitted, None)
    fields["provenance"].pop("validation_rmse", None)
    fields["provenance"]["inverse_map"] = "trained elsewhere"
    return Model(json.dumps(fields).encode())


def _inputs(network: Mapping[str, Any]) -> int:
    return len(network["features"][0])


def _array(value: Any) -> Array:
    """Returns an array of a list of numbers or of a tensor."""
    for method in ("detach", "cpu"):
        if hasattr(value, method):
            value = getattr(value, method)()
    return np.asarray(value, dtype=float)


def _pairs(layers: Any) -> list[tuple[Array, Array]]:
    if isinstance(layers, Mapping):
        names = list(layers)
        others = [name for name in names if name.rpartition(".")[2] not in ("weight", "bias")]
        if others:
            raise Error(f"layers: {others[0]} is not a weight or a bias of a linear layer: T* is an MLP")
        stems = [name[:-len("weight")] for name in names if name.endswith("weight")]
        missing = [stem + "bias" for stem in stems if stem + "bias" not in layers]
        if missing:
            raise Error(f"layers: {missing[0]} is missing")
        layers = [(layers[stem + "weight"], layers[stem + "bias"]) for stem in stems]
    pairs = [(_array(weights), _array(bias)) for weights, bias in layers]
    if not pairs:
        raise Error("layers: there are no layers")
    for index, (weights, bias) in enumerate(pairs):
        if weights.ndim != 2 or bias.shape != weights.shape[:1]:
            raise Error(f"layers[{index}]: weights {weights.shape} and bias {bias.shape}: they must be n_out x n_in and "
                        "n_out")
        if not (np.isfinite(weights).all() and np.isfinite(bias).all()):
            raise Error(f"layers[{index}]: some of its weights are not finite")
    return pairs


def _check_chain(weights: Sequence[tuple[Array, Array]], reads: int, nx: int) -> None:
    sizes = [reads, *[len(bias) for _, bias in weights]]
    for index, (w, _) in enumerate(weights):
        if w.shape[1] != sizes[index]:
            given = f"the one before it gives {sizes[index]}" if index else f"and T* is given {reads}"
            raise Error(f"layers[{index}] reads {w.shape[1]} numbers, {given}")
    if sizes[-1] != nx:
        raise Error(f"the last layer gives {sizes[-1]} numbers: the model estimates {nx} states")


def _identity(reads: int, n_z: int, n_in: int) -> Array:
    """Returns the matrix whose features are the first `reads` entries of [z; readings]."""
    if reads not in (n_z, n_in):
        both = f"{n_z} (z)" if n_in == n_z else f"{n_z} (z) or {n_in} (z and the readings)"
        raise Error(f"layers[0] reads {reads} numbers: T* of this model may read {both}")
    return np.eye(reads, n_in)


def _numbers(given: Optional[npt.ArrayLike], size: int, default: float, what: str) -> list[float]:
    numbers = np.full(size, default) if given is None else np.asarray(given, dtype=float)
    if numbers.shape != (size,):
        raise Error(f"{what} has the shape {numbers.shape}: it must be ({size},)")
    result: list[float] = numbers.tolist()
    return result

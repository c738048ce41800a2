# SPDX-License-Identifier: MIT
"""Training, evaluation and export by the program `nlo`, with the options of its commands as keywords.

`seeds=20` is --seeds 20, `box_scale=2` is --box-scale 2, a list repeats its option, True is a flag: see `nlo COMMAND
--help`. If a command fails, its text on stderr is that of the raised nlo.Error.
"""
from __future__ import annotations

import contextlib
import csv
import dataclasses
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import warnings
from typing import IO, Any, Callable, Iterator, Mapping, Optional, Sequence, Union

import numpy as np

from nlo import _tables
from nlo._arrays import Array
from nlo._library import Error, package
from nlo.model import Model

Path = Union[str, "os.PathLike[str]"]
ModelOrPath = Union[Model, Path]
_POLL_S = 0.2
_ERROR = "nlo: error: "


@dataclasses.dataclass(frozen=True, repr=False)
class Evaluation:
    """Errors of an observer under one condition. rmse: root mean square error of each state, by its name."""

    noise: str
    rmse: dict[str, float]
    norm: float                           #: root mean square of the norm of the error
    settled: Optional[float]              #: the same after the transient at the start of each run
    in_domain: float                      #: share of the samples whose z is in the domain of the training
    against: dict[str, dict[str, float]]  #: rmse of the alternatives: "constant", "ridge", "ekf", ...
    facts: dict[str, Any]                 #: everything that `nlo evaluate --json` prints

    def __repr__(self) -> str:
        states = ", ".join(f"{name} {error:.3g}" for name, error in self.rmse.items())
        return f"<nlo.Evaluation under noise {self.noise}: norm {self.norm:.3g}; RMSE {states}>"


@dataclasses.dataclass(frozen=True, repr=False)
class Training:
    """A finished training."""

    model: Model
    directory: pathlib.Path
    metrics: dict[str, Array]  #: columns of metrics.csv: step, loss, train_rmse, validation_rmse, lambda_1_re, ...
    report: pathlib.Path       #: a page with pictures
    text: str                  #: the table of errors that nlo train prints

    def __repr__(self) -> str:
        return (f"<nlo.Training in {self.directory}: {int(self.metrics['step'][-1])} steps, validation_rmse "
                f"{np.nanmin(self.metrics['validation_rmse']):.3g}>")


@dataclasses.dataclass(frozen=True)
class Export:
    """The written file or folder, and the text that the command prints about its arithmetic."""

    path: pathlib.Path
    text: str


def program() -> str:
    """Returns the path of the program `nlo`: from NLO_PROGRAM, else in the wheel, in the same prefix, or in PATH."""
    beside = [package / "bin" / "nlo", *(above / "bin" / "nlo" for above in package.parents[3:4])]
    found = os.environ.get("NLO_PROGRAM") or next((str(path) for path in beside if path.exists()), shutil.which("nlo"))
    if not found:
        raise Error("the program nlo is not installed: install the package nlo, or name it in NLO_PROGRAM")
    return found


def environment() -> dict[str, str]:
    """Returns the environment for the program, with the libraries of the wheel in LD_LIBRARY_PATH."""
    own = package / "lib"
    if not own.exists():
        return dict(os.environ)
    others = os.environ.get("LD_LIBRARY_PATH")
    return {**os.environ, "LD_LIBRARY_PATH": f"{own}:{others}" if others else str(own)}


def command_line() -> None:
    """Runs the wheel's program as the command `nlo`."""
    os.execve(program(), ["nlo", *sys.argv[1:]], environment())


def train(experiment: Union[Path, Mapping[str, Any]], data: Any = None, output: Optional[Path] = None,
          progress: Optional[Callable[[dict[str, float]], None]] = None, **options: Any) -> Training:
    """Trains an observer.

    experiment  an experiment file, the name of a shipped one, or its keys as a dict
    data        the folder of the logs that [log] names; or a DataFrame, or a dict of DataFrames by file names. Frames
                are written as CSV into `output`/data. If [log] does not name files, those whose names start with "test"
                are for the test and the others for training
    output      the folder of the run; None: runs/NAME
    progress    function, called with each new row of metrics.csv: step, loss, train_rmse, validation_rmse, ...
    options     those of `nlo train`: seed, threads, resume, force, auto, minutes, set=["training.steps=500"], ...

    Ctrl-C stops the training; the folder then has the best model so far, and resume=True continues the training.
    """
    tables = None if data is None or isinstance(data, (str, os.PathLike)) else _tables.named(data)
    name = experiment.get("name") if isinstance(experiment, Mapping) else pathlib.Path(experiment).stem
    directory = pathlib.Path(output) if output is not None else pathlib.Path("runs") / str(name or "experiment")
    if isinstance(experiment, Mapping):
        directory.mkdir(parents=True, exist_ok=True)
        keys = _tables.with_files(experiment, tables) if tables else experiment
        experiment = directory / "experiment.toml"
        experiment.write_text(_tables.toml(keys), encoding="utf-8")
    if tables is not None:
        _tables.write(tables, directory / "data")
        data = directory / "data"
    words = [os.fspath(experiment), "-o", os.fspath(directory), *_words(options)]
    if data is not None:
        words += ["--data", os.fspath(data)]
    text = _run("train", words, _Rows(directory / "metrics.csv", progress) if progress else None)
    return Training(Model.load(directory / "model.json"), directory, _columns(directory / "metrics.csv"),
                    directory / "report.html", text)


def evaluate(model: Union[ModelOrPath, Sequence[ModelOrPath]], noise: Union[str, Sequence[str]] = (),
             data: Any = None, **options: Any) -> list[Evaluation]:
    """Returns one Evaluation for each noise, on new runs of the model's plant; or on logs that did not train it.

    model    a model or its file; a list of models of one experiment gives means over training seeds
    noise    "none", "gaussian:0.5", "uniform:3", ...
    data     the path of a log, a list of paths, or DataFrames
    options  those of `nlo evaluate`: seeds, trajectories, against=["ekf"], box_scale, set=["plant.parameters.mu=1.2"], ...
    """
    with contextlib.ExitStack() as stack:
        models = [model] if isinstance(model, (Model, str, os.PathLike)) else list(model)
        words = [stack.enter_context(_file_of(each)) for each in models]
        for each in [noise] if isinstance(noise, str) else noise:
            words += ["--noise", each]
        if data is not None:
            if isinstance(data, (str, os.PathLike)):
                data = [data]
            paths = isinstance(data, Sequence) and all(isinstance(each, (str, os.PathLike)) for each in data)
            if not paths:
                folder = stack.enter_context(tempfile.TemporaryDirectory())
                data = _tables.write(_tables.named(data), pathlib.Path(folder))
            words += ["--data", *[os.fspath(each) for each in data]]
        found = json.loads(_run("evaluate", [*words, "--json", *_words(options)]))
    return [_evaluation(facts) for facts in found]


def export(model: ModelOrPath, target: str = "cpp", path: Path = "", **options: Any) -> Export:
    """Writes the observer as code into the file or folder `path`.

    target   a target of `nlo export`: "cpp", "c99", "single", "arduino", "zephyr", ...
    options  those of `nlo export`: scalar="int16", weights="bf16", max_error="0.01", name="..."
    """
    if not os.fspath(path):
        raise Error("path is missing: the file or folder to write")
    with _file_of(model) as file:
        text = _run("export", [file, "--target", target, "-o", os.fspath(path), *_words(options)])
    return Export(pathlib.Path(path), text)


def _words(options: Mapping[str, Any]) -> list[str]:
    words = []
    for name, value in options.items():
        option = "--" + name.replace("_", "-")
        if isinstance(value, Mapping):
            value = [f"{key}={each}" for key, each in value.items()]
        for each in value if isinstance(value, (list, tuple)) else [value]:
            if each is True:
                words.append(option)
            elif each is not None and each is not False:
                words += [option, str(each)]
    return words


class _Rows:
    """Calls `progress` with each new row of a metrics.csv. The trainer replaces the file when it adds a row."""

    def __init__(self, path: pathlib.Path, progress: Callable[[dict[str, float]], None]) -> None:
        self._path, self._progress, self._step = path, progress, -1.0
        self._old = self._now()

    def _now(self) -> Optional[tuple[int, int]]:
        """Returns the inode and the time of the file, or None if there is no file."""
        with contextlib.suppress(OSError):
            status = self._path.stat()
            return status.st_ino, status.st_mtime_ns
        return None

    def __call__(self) -> None:
        if self._now() == self._old:
            return  # there is no file yet, or only that of an earlier run
        with open(self._path, newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                numbers = {key: float(value) for key, value in row.items()}
                if numbers["step"] > self._step:
                    self._step = numbers["step"]
                    self._progress(numbers)


def _columns(path: pathlib.Path) -> dict[str, Array]:
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]} if rows else {}


def _run(command: str, words: Sequence[str], watch: Optional[Callable[[], None]] = None) -> str:
    """Runs the command and returns its stdout. Passes the first KeyboardInterrupt on, so the command ends in order."""
    with tempfile.TemporaryFile("w+", encoding="utf-8") as out, tempfile.TemporaryFile("w+", encoding="utf-8") as err:
        # The command runs in its own session. Ctrl-C in a terminal reaches it only once: this process passes it on.
        child = subprocess.Popen([program(), command, *words], stdin=subprocess.DEVNULL, stdout=out, stderr=err,
                                 start_new_session=True, env=environment())
        try:
            while child.poll() is None:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    child.wait(_POLL_S)
                if watch:
                    watch()
        except BaseException as error:  # also what `watch` raises
            child.send_signal(signal.SIGINT)
            child.wait()
            if isinstance(error, KeyboardInterrupt):
                raise KeyboardInterrupt(*_said(err, _ERROR)) from None
            raise
        for warning in _said(err, "warning: "):
            warnings.warn(warning, stacklevel=3)
        if child.returncode != 0:
            raise Error(*_said(err, _ERROR)[-1:] or [f"nlo {command} ended with {child.returncode}"])
        out.seek(0)
        return out.read()


def _said(stream: IO[str], kind: str) -> list[str]:
    """Returns the lines of stderr that begin with `kind`, without this beginning."""
    stream.seek(0)
    return [line[len(kind):].rstrip("\n") for line in stream if line.startswith(kind)]


@contextlib.contextmanager
def _file_of(model: ModelOrPath) -> Iterator[str]:
    if not isinstance(model, Model):
        yield os.fspath(model)
        return
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "model.json"
        model.save(path)
        yield str(path)


def _evaluation(facts: dict[str, Any]) -> Evaluation:
    names = [state["name"] for state in facts["states"]]
    if "per_state" in facts:  # on logs
        against: dict[str, dict[str, float]] = {}
        for state in facts["per_state"]:
            for other, windows in state["against"].items():
                against.setdefault(other, {})[state["name"]] = windows["all"]
    else:
        against = {other: dict(zip(names, each["per_component"])) for other, each in facts["against"].items()}
    return Evaluation(facts["noise"], dict(zip(names, facts["per_component"])), facts["norm"], facts["settled"],
                      facts["in_domain"]["share"], against, facts)

# SPDX-License-Identifier: MIT
"""Compares exported C99 with its model: compiles it and gives it replay inputs."""
from __future__ import annotations

import dataclasses
import os
import pathlib
import shutil
import subprocess
import tempfile

import numpy as np
import numpy.typing as npt

from nlo._arrays import Array
from nlo._library import Error
from nlo.program import ModelOrPath, Path, export

_MAIN = """#include "NAME.h"
#include "NAME_replay.h"
#include <stdio.h>

int main(void) {
  static NAME_observer observer;
  const int samples = (int)(sizeof NAME_replay_samples / sizeof NAME_replay_samples[0]);
  NAME_init(&observer);
  for (int k = 0; k < samples; ++k) {
    const NAME_replay_sample* sample = &NAME_replay_samples[k];
    const int states = (int)(sizeof sample->x_hat / sizeof sample->x_hat[0]);
    SCALAR x_hat[sizeof sample->x_hat / sizeof sample->x_hat[0]];
    const int status = sample->dt_s > 0 ? (int)NAME_step_dt(&observer, sample->yINPUTS, sample->dt_s)
                                        : (int)NAME_step(&observer, sample->yINPUTS);
    NAME_estimate(&observer, x_hat);
    printf("%d %d", status, (int)sample->status);
    for (int i = 0; i < states; ++i) printf(" %.17g", (double)x_hat[i]);
    for (int i = 0; i < states; ++i) printf(" %.17g", (double)sample->x_hat[i]);
    for (int i = 0; i < states; ++i) printf(" %.17g", (double)NAME_estimate_tolerance[i]);
    printf("\\n");
  }
  return 0;
}
"""


@dataclasses.dataclass(frozen=True, repr=False)
class Validation:
    """The estimates of an export and of its model over N replay samples."""

    exported: Array                         #: N x n_x, estimates of the compiled code
    model: Array                            #: N x n_x, estimates of the model's equations in double
    tolerance: Array                        #: n_x, largest difference that the arithmetic of the export explains
    status_agrees: npt.NDArray[np.bool_]    #: N, true if both have the same status

    @property
    def max_error(self) -> Array:
        """The largest difference of each state, n_x."""
        largest: Array = np.abs(self.exported - self.model).max(axis=0)
        return largest

    @property
    def passed(self) -> bool:
        return bool((self.max_error <= self.tolerance).all() and self.status_agrees.all())

    def __repr__(self) -> str:
        return (f"<nlo.Validation {'passed' if self.passed else 'failed'}: {len(self.model)} samples, "
                f"largest errors {self.max_error}, allowed {self.tolerance}>")


def validate(model: ModelOrPath, header: Path, scalar: str = "float") -> Validation:
    """Compiles an exported C99 pair, gives it the model's replay inputs, and compares its estimates with the model's.

    header  NAME.h of nlo.export(model, "c99", "NAME.h"), with NAME.c beside it; compiled by cc, or by $CC
    scalar  the number format of the export
    """
    path = pathlib.Path(header)
    name, source = path.stem, path.with_suffix(".c")
    for file in (path, source):
        if not file.exists():
            raise Error(f"{file}: no such file; nlo.export(model, \"c99\", \"{path}\") writes the pair")
    compiler = shutil.which(os.environ.get("CC", "cc"))
    if compiler is None:
        raise Error("there is no C compiler: install gcc or clang, or name one in CC")
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        export(model, "replay-c99", work / f"{name}_replay.h", name=name, scalar=scalar)
        takes_inputs = " u[" in (work / f"{name}_replay.h").read_text(encoding="utf-8")
        inputs = ", sample->u" if takes_inputs else ""
        main = _MAIN.replace("NAME", name).replace("INPUTS", inputs)
        (work / "main.c").write_text(main.replace("SCALAR", "double" if scalar == "double" else "float"))
        built = subprocess.run([compiler, "-std=c99", "-O1", "-I", str(path.parent.resolve()), "-I", folder, "main.c",
                                str(source.resolve()), "-o", "main", "-lm"], cwd=folder, capture_output=True, text=True)
        if built.returncode != 0:
            raise Error(f"{path}: it does not compile with the replay of the model:\n{built.stderr.strip()}")
        ran = subprocess.run([str(work / "main")], capture_output=True, text=True)
        if ran.returncode != 0:
            raise Error(f"{path}: the compiled code ended with {ran.returncode}")
    table = np.array([[float(number) for number in line.split()] for line in ran.stdout.splitlines()])
    nx = (table.shape[1] - 2) // 3
    exported, wanted, tolerance = (table[:, 2 + i * nx:2 + (i + 1) * nx] for i in range(3))
    return Validation(exported, wanted, tolerance[0], table[:, 0] == table[:, 1])

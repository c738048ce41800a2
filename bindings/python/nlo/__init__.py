# SPDX-License-Identifier: MIT
"""Learned state observers for control loops: load one, run it over arrays, train, evaluate and export.

    import nlo
    model = nlo.Model.load("model.json")
    run = model.run(y)              # x_hat, sigma, z, status, in_domain as arrays
    observer = model.observer()     # or sample by sample
    observer.step(y[0])
    x_hat = observer.estimate()

Observers run in libnlo-model, trainings in the program `nlo`: the same code as for C and on the command line.
"""
from nlo._arrays import Channel
from nlo._library import Error, Status, __version__
from nlo.bag import read_bag
from nlo.mat import read_mat
from nlo.model import Model, Run
from nlo.observer import Observer
from nlo.program import Evaluation, Export, Training, evaluate, export, train
from nlo.validate import Validation, validate

__all__ = ["Channel", "Error", "Evaluation", "Export", "Model", "Observer", "Run", "Status", "Training", "Validation",
           "__version__", "evaluate", "export", "read_bag", "read_mat", "train", "validate"]

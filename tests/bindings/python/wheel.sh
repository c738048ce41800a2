#!/bin/sh
# SPDX-License-Identifier: MIT
# The wheel as a user installs it: by pip into an empty environment, run in an empty folder.
#   usage: wheel.sh SOURCE_DIR BUILD_DIR WORK_DIR PYTHON
set -eu
source=$1 build=$2 work=$3 python=$4
rm -rf "$work"
mkdir -p "$work/empty"
fail() {
  echo "FAILED: $*"
  exit 1
}
# numpy is that of the system, so nothing is downloaded
"$python" -m venv --system-site-packages "$work/venv" 2>/dev/null || { echo 'skipped: there is no python3-venv'; exit 77; }
wheel=$("$python" "$source/bindings/python/make_wheel.py" "$build" -o "$work")
again=$("$python" "$source/bindings/python/make_wheel.py" "$build" -o "$work/again")
cmp "$wheel" "$again" || fail 'the same build gives other bytes'
"$work/venv/bin/pip" install --quiet --no-index --no-deps "$wheel"
cd "$work/empty"
unset NLO_MODEL_LIBRARY NLO_PROGRAM PYTHONPATH LD_LIBRARY_PATH
[ "$("$work/venv/bin/nlo" --version)" = "nlo $("$work/venv/bin/python" -c 'import nlo; print(nlo.__version__)')" ] ||
  fail 'program and package are of two versions'
cp "$source/examples/models/van_der_pol.json" model.json
"$work/venv/bin/python" - <<'END'
import pathlib
import nlo

assert pathlib.Path(nlo.__file__).parents[4].samefile("../venv"), nlo.__file__
model = nlo.Model.load("model.json")
assert model.run([0.5, 0.51]).x_hat.shape == (2, 2)
assert nlo.evaluate(model, noise="none", trajectories=3)[0].rmse["x1"] < 0.5
training = nlo.train("van_der_pol", set=["training.steps=100"], output="run")
print(training.model)
assert nlo.validate(training.model, nlo.export(training.model, "c99", "van_der_pol.h").path).passed
END
"$work/venv/bin/pip" uninstall --quiet --yes nlo
if "$work/venv/bin/python" -c 'import nlo' 2>/dev/null; then fail 'it is still there'; fi

# SPDX-License-Identifier: MIT
"""Runs the code cells of each notebook, in order, in an empty folder."""
import contextlib
import io
import json
import os
import pathlib
import tempfile
import unittest

PACKAGE = pathlib.Path(os.environ["NLO_SOURCE_DIR"]) / "bindings/python"


def run_in(folder, sources, names):
    """Runs the sources and returns the names that they define; an error names its source."""
    here = os.getcwd()
    os.chdir(folder)
    try:
        for index, source in enumerate(sources):
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile(source, f"cell {index}", "exec"), names)
    finally:
        os.chdir(here)
    return names


def code_cells(path):
    return ["".join(cell["source"]) for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]


class Notebooks(unittest.TestCase):
    def test_every_notebook_runs_from_its_first_cell_to_its_last(self):
        paths = sorted((PACKAGE / "notebooks").glob("*.ipynb"))
        self.assertEqual([path.stem for path in paths], ["your_own_log", "your_own_plant"])
        for path in paths:
            with self.subTest(notebook=path.name), tempfile.TemporaryDirectory() as folder:
                names = run_in(folder, code_cells(path), {})
                self.assertTrue(names["nlo"].validate)
                for cell in json.loads(path.read_text())["cells"]:
                    self.assertFalse(cell.get("outputs"), "a notebook must be stored without its output")

    def test_a_cell_that_fails_is_detected(self):
        with tempfile.TemporaryDirectory() as folder, self.assertRaisesRegex(AssertionError, "control"):
            run_in(folder, ["a = 1", "assert a == 2, 'control'"], {})


if __name__ == "__main__":
    unittest.main()

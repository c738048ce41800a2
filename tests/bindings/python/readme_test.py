# SPDX-License-Identifier: MIT
"""Runs the code blocks of the package's README, in order, in an empty folder."""
import os
import pathlib
import re
import tempfile
import unittest

import numpy as np

from notebook_test import PACKAGE, run_in


class Readme(unittest.TestCase):
    def test_its_blocks_run_in_order(self):
        blocks = re.findall(r"^```python\n(.*?)^```", (PACKAGE / "README.md").read_text(), re.M | re.S)
        t = 0.02 * np.arange(600)

        def frame(phase):
            return {"time": t, "angle": np.cos(4 * t + phase), "rate": -4 * np.sin(4 * t + phase)}

        class Network:
            def state_dict(self):
                return {"0.weight": np.ones((3, 6)), "0.bias": np.zeros(3),
                        "2.weight": np.ones((2, 3)), "2.bias": np.zeros(2)}

        names = {"frame_1": frame(0), "frame_2": frame(1), "frame_3": frame(2), "network": Network()}
        with tempfile.TemporaryDirectory() as folder:
            os.symlink(PACKAGE.parent.parent / "examples", pathlib.Path(folder) / "examples")
            names = run_in(folder, blocks, names)
        self.assertEqual(names["training"].model.name, "swing")
        self.assertEqual(names["mine"].name, "van_der_pol")


if __name__ == "__main__":
    unittest.main()

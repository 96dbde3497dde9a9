"""The tutorial, run from top to bottom without Jupyter; and what the runner says of a notebook that fails."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

import numpy as np

from hapton.run_notebook import run_notebook

os.environ.setdefault("MPLBACKEND", "Agg")  # no window, where matplotlib is installed
TUTORIAL = os.path.join(os.environ["HAPTON_SOURCE_DIR"], "examples", "python", "tutorial.ipynb")


def write_notebook(folder, *cells):
    path = os.path.join(folder, "a.ipynb")
    with open(path, "w") as file:
        json.dump({"cells": [{"cell_type": kind, "source": source} for kind, source in cells]}, file)
    return path


class NotebookTest(unittest.TestCase):
    def test_the_tutorial_runs(self):
        names = run_notebook(TUTORIAL)
        self.assertAlmostEqual(names["stiffness_n_per_m"], 500.0, delta=5.0)
        self.assertGreater(names["force_n"].max(), 2.0)
        self.assertTrue(names["held"]["contact"][-1])
        self.assertGreater(np.linalg.norm(names["held"]["torque_nm"][-1]), 0.0)
        # Honey takes energy, a mass less of it, and a spring hardly any over whole swings.
        self.assertLess(names["work_j"]["honey"], 3 * names["work_j"]["mass"])
        self.assertLess(names["work_j"]["mass"], 3 * names["work_j"]["spring"])
        self.assertGreater(np.nanmax(names["given_n"]), 0.5)

    def test_the_tutorial_has_no_outputs(self):
        with open(TUTORIAL) as file:
            notebook = json.load(file)
        self.assertEqual(notebook["nbformat"], 4)
        for cell in notebook["cells"]:
            self.assertFalse(cell.get("outputs"), "clear all outputs before it is saved")

    def test_a_cell_that_fails_is_named(self):
        with tempfile.TemporaryDirectory() as folder:
            path = write_notebook(folder, ("markdown", "# no code"), ("code", "%matplotlib inline\nx = 2"), ("code", ["y = x\n", "y / 0"]))
            with self.assertRaisesRegex(RuntimeError, "a.ipynb: cell 3: ZeroDivisionError"):
                run_notebook(path)
            ran = subprocess.run([sys.executable, "-m", "hapton.run_notebook", path], capture_output=True, text=True)
            self.assertEqual(ran.returncode, 1)
            self.assertEqual(ran.stderr.count("\n"), 1, ran.stderr)
            self.assertIn("cell 3: ZeroDivisionError", ran.stderr)


if __name__ == "__main__":
    unittest.main()

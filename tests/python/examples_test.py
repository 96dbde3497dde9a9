"""The Python examples, run as their first lines say, for a few trials."""
import os
import subprocess
import sys
import unittest

import numpy as np

from live_system import SOURCE, LiveSystem


class ExamplesTest(unittest.TestCase):
    def test_reaching_task(self):
        with LiveSystem("--rate", "2000") as system:
            out = system.path("trials.npz")
            script = os.path.join(SOURCE, "examples", "reaching_task.py")
            run = subprocess.run([sys.executable, script, "2", system.hub, out], capture_output=True, text=True, timeout=60)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertRegex(run.stdout, r"trial 1: .* mm from the target")
            self.assertRegex(run.stdout, r"[1-9][0-9]* forces, [1-9]")
            trials = np.load(out)["trials"]
            self.assertEqual(set(trials[:, 0]), {0, 1})
            self.assertTrue(np.isfinite(trials).all())

    def test_streamed_membrane(self):
        with LiveSystem("--rate", "1000") as system:
            script = os.path.join(SOURCE, "examples", "streamed_membrane.py")
            run = subprocess.run([sys.executable, script, "3", system.hub], capture_output=True, text=True, timeout=60)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertRegex(run.stdout, r"[1-9][0-9]* shapes, the lowest vertex at ")
            self.assertRegex(run.stdout, r"[1-9][0-9]* forces a second")

    def test_streamed_membrane_ends_where_there_is_no_hub(self):
        script = os.path.join(SOURCE, "examples", "streamed_membrane.py")
        run = subprocess.run([sys.executable, script, "3", "127.0.0.1:1"], capture_output=True, text=True, timeout=60)
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertIn("ValueError", run.stderr)

    def test_swelling_block(self):
        with LiveSystem("--rate", "1000", scene="swelling.toml") as system:
            script = os.path.join(SOURCE, "examples", "swelling_block.py")
            run = subprocess.run([sys.executable, script, "2", system.hub], capture_output=True, text=True, timeout=60)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertRegex(run.stdout, r"[1-9][0-9]* shapes given; back at rest in [0-9.]+ s")

    def test_examples_are_short(self):
        folder = os.path.join(SOURCE, "examples")
        for name in os.listdir(folder):
            if os.path.isdir(os.path.join(folder, name)):
                continue  # notebooks
            with open(os.path.join(folder, name)) as file:
                self.assertLess(len(file.readlines()), 61, name)


if __name__ == "__main__":
    unittest.main()

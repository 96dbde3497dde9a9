"""Runs the Python code of docs/python.md from top to bottom, beside a session."""
import os
import re
import unittest

import numpy as np

from live_system import BIN, SOURCE, LiveSystem

# Replacements in the text, because a test does not have what a reader has: the default port, the recording monday.hapton, ten seconds.
REPLACEMENTS = [
    ("hapton.Client()", "hapton.Client(HUB)"),
    ("hapton.FieldNode()", "hapton.FieldNode(HUB)"),
    ("seconds=10)", "seconds=0.5, hub=HUB)"),
    ('"monday.hapton"', "RECORDING"),
]


def read_blocks():
    with open(os.path.join(SOURCE, "docs", "python.md")) as file:
        return re.findall(r"^```python\n(.*?)^```", file.read(), re.MULTILINE | re.DOTALL)


class DocsTest(unittest.TestCase):
    def test_every_block_runs(self):
        blocks = read_blocks()
        self.assertGreaterEqual(len(blocks), 5)
        text = "".join(blocks)
        for in_docs, in_test in REPLACEMENTS:
            self.assertEqual(text.count(in_docs), 1, in_docs)
        os.chdir(SOURCE)
        os.environ["PATH"] = BIN + os.pathsep + os.environ["PATH"]  # the folder of the program hapton
        recording = os.path.join(os.environ.get("TMPDIR", "/tmp"), f"hapton-docs-{os.getpid()}.hapton")
        self.addCleanup(lambda: os.path.exists(recording) and os.remove(recording))
        with LiveSystem("--record", recording, scene="thin_wall.toml") as system:
            system.record_for(1.0, recording)
            system.end_io()
        marked = recording + ".marked"
        self.addCleanup(lambda: os.path.exists(marked) and os.remove(marked))
        with LiveSystem("--record", marked) as system:
            names = {"HUB": system.hub, "RECORDING": recording, "pose": np.eye(4)}
            for block in blocks:
                for in_docs, in_test in REPLACEMENTS:
                    block = block.replace(in_docs, in_test)
                with self.subTest(block):
                    exec(block, names)
            self.assertTrue(names["felt"]["contact"].any(), "the first example touches nothing")


if __name__ == "__main__":
    unittest.main()

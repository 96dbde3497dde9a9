"""Shapes that a program gives an object, as `hapton session export` writes them: read by NumPy, and by Protobuf's own Python library."""
import csv
import os
import subprocess
import tempfile
import unittest

import numpy as np

import hapton
from live_system import BIN, SOURCE, LiveSystem
from mcap_strict import McapFile

try:
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
except ImportError:  # Debian: python3-protobuf
    descriptor_pb2 = None


class ShapesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.recording = os.path.join(cls.folder.name, "monday.hapton")
        cls.rest = hapton.load_mesh(os.path.join(SOURCE, "meshes", "supple_block.obj"), unit="mm", seal=False)
        per_metre = np.maximum(0.0, cls.rest.vertices[:, 2:] / 0.02) * [0.0, 0.0, 1.0]
        cls.shapes = [height * per_metre for height in (0.001, -0.002, 0.003)]
        with LiveSystem("--record", cls.recording, scene="swelling.toml") as system:
            system.record_for(0.5, cls.recording)
            client = hapton.Client(system.hub)
            for shape in cls.shapes:
                client.set_shape("block", shape, over_s=0.1, wait=True)
            system.record_for(0.5, cls.recording)
            system.end_io()
        for form in ("tables", "mcap"):
            done = subprocess.run([os.path.join(BIN, "hapton"), "session", "export", cls.recording, "--format", form, "--out",
                                   cls.folder.name], capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
            cls.printed = done.stdout

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def check(self, displacements):
        self.assertEqual(displacements.shape, (3, *self.rest.vertices.shape))
        np.testing.assert_allclose(displacements, self.shapes, atol=1e-8)

    def test_numpy_reads_the_array_that_the_table_names(self):
        with open(os.path.join(self.folder.name, "shapes.csv"), encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([row["name"] for row in rows], ["block"] * 3)
        self.assertEqual([row["row"] for row in rows], ["0", "1", "2"])
        self.assertEqual([int(row["before"]) for row in rows[1:]], [int(row["serial"]) for row in rows[:-1]])
        for row in rows:
            self.assertGreaterEqual(float(row["end_scene_time_s"]) - float(row["start_scene_time_s"]), 0.1 - 1e-9)
        self.assertEqual(len({row["file"] for row in rows}), 1)
        self.check(np.load(os.path.join(self.folder.name, rows[0]["file"]), mmap_mode="r"))

    def test_read_session_has_each_shape_and_its_vertices_where_they_are_wanted(self):
        shapes = hapton.read_session(self.recording)["shapes"]
        self.assertEqual(shapes["vertices"].tolist(), [len(self.rest.vertices)] * 3)
        self.assertTrue(np.isnan(shapes["row"]).all())
        self.assertNotIn("displacements_m", shapes)
        np.testing.assert_array_equal(shapes["before"][1:], shapes["serial"][:-1])
        shapes = hapton.read_session(self.recording, vertices=True)["shapes"]
        self.assertEqual(shapes["row"].tolist(), [0, 1, 2])
        (key, displacements), = shapes["displacements_m"].items()
        self.assertEqual(key, (shapes["process"][0], shapes["object"][0]))
        self.check(displacements)

    def test_mcap_has_a_message_of_each_shape(self):
        if descriptor_pb2 is None:
            self.skipTest("python3-protobuf is not installed")
        mcap = McapFile(os.path.join(self.folder.name, "session.mcap"))
        factory = message_factory.MessageFactory(descriptor_pool.DescriptorPool())
        for one in descriptor_pb2.FileDescriptorSet.FromString(mcap.schemas[1][2]).file:
            factory.pool.Add(one)
        kind = factory.GetPrototype(factory.pool.FindMessageTypeByName("hapton.session.Shape"))
        shapes = [kind.FromString(message[4]) for message in mcap.messages if message[0] == "/hapton/shape"]
        self.assertEqual([shape.vertices for shape in shapes], [len(self.rest.vertices)] * 3)
        self.check(np.array([shape.displacements_m for shape in shapes]).reshape(len(shapes), -1, 3))


if __name__ == "__main__":
    unittest.main()

"""`hapton session export --format mcap`, read by a reader of the specification and by Protobuf's own Python library."""
import csv
import os
import subprocess
import tempfile
import time
import unittest

from live_system import BIN, LiveSystem
from mcap_strict import McapFile

try:
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
except ImportError:  # Debian: python3-protobuf
    descriptor_pb2 = None


def hapton(*arguments):
    return subprocess.run([os.path.join(BIN, "hapton"), *arguments], capture_output=True, text=True)


class McapTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.recording = os.path.join(cls.folder.name, "monday.hapton")
        with LiveSystem("--record", cls.recording, scene="lift.toml") as system:
            system.record_for(1.0, cls.recording)
            moved = hapton("move", "platform", "--to", "-0.05,0.01,0", "--over", "0.5", "--hub", system.hub)
            assert moved.returncode == 0, moved.stderr
            cls.marked = hapton("mark", "gezückt, \"a\"", "--hub", system.hub)
            time.sleep(0.5)
            cls.log = system.end_io()
        for form in ("csv", "mcap"):
            done = hapton("session", "export", cls.recording, "--format", form, "--out", cls.folder.name)
            assert done.returncode == 0, done.stderr
        with open(os.path.join(cls.folder.name, "session.csv"), encoding="utf-8") as file:
            cls.rows = list(csv.DictReader(file))
        cls.path = os.path.join(cls.folder.name, "session.mcap")
        cls.file = McapFile(cls.path)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def of(self, topic):
        return [message for message in self.file.messages if message[0] == topic]

    def test_is_as_the_specification_says(self):
        self.assertEqual(len(self.of("/hapton/cycle")), len(self.rows))
        self.assertGreater(len(self.of("/hapton/force")), 10)
        self.assertGreater(len(self.of("/hapton/move")), 2)
        self.assertEqual({encoding for _, encoding, _ in self.file.schemas.values()}, {"protobuf"})
        self.assertEqual(self.file.metadata["hapton.session"]["setting device"], "simulated")

    def test_a_changed_byte_is_found(self):
        with open(self.path, "rb") as file:
            good = file.read()
        bad = os.path.join(self.folder.name, "bad.mcap")
        for at in range(0, len(good), len(good) // 97):
            with open(bad, "wb") as file:
                file.write(good[:at] + bytes([good[at] ^ 4]) + good[at + 1:])
            with self.assertRaises((ValueError, KeyError, IndexError), msg=f"byte {at}"):
                McapFile(bad)

    def test_messages_say_what_the_table_says(self):
        if descriptor_pb2 is None:
            self.skipTest("python3-protobuf is not installed")
        factory = message_factory.MessageFactory(descriptor_pool.DescriptorPool())
        files = descriptor_pb2.FileDescriptorSet.FromString(self.file.schemas[1][2])
        for one in files.file:
            factory.pool.Add(one)
        kinds = {topic: factory.GetPrototype(factory.pool.FindMessageTypeByName(self.file.schemas[schema][0]))
                 for schema, topic, _ in self.file.channels.values()}
        rows = {int(float(row["sample"])): row for row in self.rows}
        start_ns = int(self.file.metadata["hapton.session"]["start_unix_ns"])
        for topic, _, log_ns, publish_ns, data in self.file.messages:
            message = kinds[topic].FromString(data)
            self.assertEqual(message.SerializeToString(), data, "no field is unknown to its schema")
            self.assertGreaterEqual(log_ns, publish_ns)
            if topic == "/hapton/cycle":
                row = rows.pop(message.sample)
                self.assertEqual(message.p_wd_m[0], float(row["x_m"]))
                self.assertEqual(message.written_n[1], float(row["written_y_n"]))
                self.assertAlmostEqual(1e-9 * (publish_ns - start_ns), float(row["t_s"]), 8)
            if topic == "/hapton/force":
                self.assertEqual(len(message.force_n), 3)
        self.assertEqual(rows, {}, "every sample is there")
        self.check_moves([kinds["/hapton/move"].FromString(m[4]) for m in self.of("/hapton/move")])
        events = [kinds["/hapton/event"].FromString(m[4]) for m in self.of("/hapton/event")]
        markers = [event for event in events if event.kind == "marker"]
        self.assertEqual([event.name for event in markers], ['gezückt, "a"'])
        self.assertEqual(f"marked sample {markers[0].sample}: gezückt, \"a\"\n", self.marked.stdout)

    def check_moves(self, moves):
        self.assertEqual({move.object for move in moves}, {1, 2}, "of the platform and the lid")
        self.assertEqual(len({move.source for move in moves}), 1)
        self.assertEqual({move.serial for move in moves if move.object == 2}, {0}, "nobody moved the lid")
        requested = [move for move in moves if move.serial == 1]
        self.assertGreater(len(requested), 0)
        for move in requested:
            self.assertEqual((move.object, move.end_ns - move.start_ns), (1, 500_000_000))
            self.assertGreater(move.to_p_m[1], move.from_p_m[1])
            self.assertEqual(list(move.to_q), [1.0, 0.0, 0.0, 0.0])

    def test_the_marker_is_in_the_table(self):
        marked = [row for row in self.rows if row["marker"]]
        self.assertEqual([row["marker"] for row in marked], ['gezückt, "a"'])
        self.assertIn(f"marked sample {int(float(marked[0]['sample']))}:", self.marked.stdout)

    def test_a_disk_that_is_full_is_one_line(self):
        folder = os.path.join(self.folder.name, "full")
        os.makedirs(folder)
        for form, name in (("mcap", "session.mcap"), ("csv", "session.csv")):
            os.symlink("/dev/full", os.path.join(folder, name))
            done = hapton("session", "export", self.recording, "--format", form, "--out", folder)
            self.assertEqual(done.returncode, 1)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertIn("No space left on device", done.stderr)


if __name__ == "__main__":
    unittest.main()

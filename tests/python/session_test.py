"""hapton.read_session, beside `hapton session export` of the same recording."""
import csv
import os
import struct
import subprocess
import tempfile
import unittest
import zlib

import numpy as np

import hapton

try:
    import h5py
except ImportError:  # Debian: python3-h5py
    h5py = None
from live_system import BIN, LiveSystem


class SessionTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.recording = os.path.join(cls.folder.name, "monday.hapton")
        with LiveSystem("--record", cls.recording, scene="thin_wall.toml") as system:
            system.record_for(1.5, cls.recording)
            subprocess.run([os.path.join(BIN, "hapton"), "mark", "gezückt", "--hub", system.hub], check=True, capture_output=True)
            system.end_io()
        export = [os.path.join(BIN, "hapton"), "session", "export", cls.recording, "--format", "csv", "--out", cls.folder.name]
        subprocess.run(export, check=True, capture_output=True)
        with open(os.path.join(cls.folder.name, "session.csv")) as file:
            cls.rows = list(csv.DictReader(file))
        cls.session = hapton.read_session(cls.recording)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_has_every_cycle_once(self):
        samples = self.session["sample"]
        self.assertGreater(len(samples), 50)
        self.assertTrue((np.diff(samples) > 0).all())
        self.assertEqual(len(samples), len(self.rows))

    def test_agrees_with_the_exported_table(self):
        for name in ["t_s", "sample", "x_m", "qw", "vx_m_per_s", "buttons", "wanted_y_n", "written_y_n", "contact", "round_trip_s", "missed"]:
            exported = np.array([float(row[name]) if row[name] else np.nan for row in self.rows])
            np.testing.assert_allclose(self.session[name], exported, rtol=1e-6, atol=1e-9, err_msg=name)

    def test_each_column_has_its_unit(self):
        units = self.session["units"]
        self.assertEqual(units["x_m"], "m")
        self.assertEqual(units["written_x_n"], "N")
        for name in units:
            self.assertEqual(self.session[name].dtype, np.float64)
            self.assertEqual(self.session[name].shape, self.session["t_s"].shape)

    def test_hdf5_has_units_names_and_events(self):
        if h5py is None:
            self.skipTest("python3-h5py is not installed")
        export = [os.path.join(BIN, "hapton"), "session", "export", self.recording, "--format", "hdf5", "--out", self.folder.name]
        subprocess.run(export, check=True, capture_output=True)
        with h5py.File(os.path.join(self.folder.name, "session.h5")) as file:
            for name, unit in self.session["units"].items():
                column = file["samples"][name]
                self.assertEqual(column.attrs["unit"], unit)
                np.testing.assert_array_equal(column[:], self.session[name], err_msg=name)
            self.assertEqual([name.decode() for name in file["objects/name"]], ["wall"])
            self.assertEqual([name.decode() for name in file["events/name"]], self.session["event"])
            self.assertEqual([kind.decode() for kind in file["events/kind"]], self.session["event_kind"])
            self.assertIn("marker", self.session["event_kind"])
            self.assertEqual(file["events/t_s"].attrs["unit"], "s")
            self.assertEqual(file.attrs["schema"], "hapton.table/1")
            haptics = self.session["header"]["haptics"]
            for name in ["scene", "scene_hash", "loading", "method", "build"]:
                self.assertEqual([text.decode() for text in file["haptics"][name]], [setup[name] for setup in haptics])

    def test_says_what_it_is(self):
        header = self.session["header"]
        self.assertEqual(header["settings"]["device"], "simulated")
        self.assertGreater(header["start_unix_ns"], 0)
        (haptics,) = header["haptics"]
        self.assertRegex(haptics["method"], "name=proxy")
        self.assertRegex(haptics["scene_hash"], "^[0-9a-f]{16}$")
        self.assertRegex(haptics["loading"], "^unit .*, cracks sealed")
        self.assertTrue(os.path.exists(haptics["scene"]), haptics["scene"])
        self.assertEqual(self.session["problem"], "")
        self.assertEqual(len(self.session["event"]), len(self.session["event_t_s"]))

    def test_reads_a_truncated_file_up_to_its_end(self):
        cut = os.path.join(self.folder.name, "cut.hapton")
        with open(self.recording, "rb") as file:
            data = file.read()
        problems = []
        for shorter in (0, 1):  # one of the two ends within a record
            with open(cut, "wb") as file:
                file.write(data[: len(data) * 2 // 3 - shorter])
            session = hapton.read_session(cut)
            problems.append(session["problem"])
            self.assertGreater(len(session["t_s"]), 10)
            self.assertLess(len(session["t_s"]), len(self.session["t_s"]))
        self.assertTrue(any(problems))

    def test_a_path_that_was_cut_within_a_letter_is_shown(self):
        with tempfile.TemporaryDirectory() as folder:
            # 255 bytes are kept, the last ones: they begin with the second byte of an e with an accent.
            deep = os.path.join(folder, "\u00e9" * 120, "\u00e9" * 120)
            os.makedirs(deep)
            with open(os.path.join(deep, "sheets.obj"), "w") as file:
                file.write("v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n")
            recording = os.path.join(folder, "deep.hapton")
            with LiveSystem("--record", recording, scene=os.path.join(deep, "sheets.obj")) as system:
                system.record_for(0.5, recording, least_bytes=20_000)
                system.io.terminate()
                system.io.wait(30)
            (haptics,) = hapton.read_session(recording)["header"]["haptics"]
            self.assertEqual(haptics["scene"], "\ufffd\u00e9/" + "\u00e9" * 120 + "/sheets.obj")

    def test_rejects_what_is_no_recording(self):
        with self.assertRaisesRegex(ValueError, "nowhere.hapton"):
            hapton.read_session("nowhere.hapton")
        with self.assertRaises(ValueError):
            hapton.read_session(__file__)


def field_of_bytes(number, content):
    return varint(number << 3 | 2) + varint(len(content)) + content


def varint(number):
    return bytes([number]) if number < 0x80 else bytes([number & 0x7F | 0x80]) + varint(number >> 7)


def with_checksum(body):
    """A message of a recording, with its length and its check."""
    return varint(len(body) + 5) + body + b"\x7d" + struct.pack("<I", zlib.crc32(body))


def recording_of(haptics_setup):
    envelope = b"\x08\x03" + field_of_bytes(26, haptics_setup)
    datagram = field_of_bytes(1, bytes(10) + b"\xff\xff\x7f\x00\x00\x01") + b"\x10\x01" + field_of_bytes(3, envelope)
    return b"hapton.session/1\n" + with_checksum(b"") + with_checksum(field_of_bytes(2, datagram))


class TextsTest(unittest.TestCase):
    def test_a_path_that_is_not_utf8_is_read(self):
        pose = struct.pack("<12f", 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0)
        setup = field_of_bytes(3, pose) + field_of_bytes(5, b"/home/a/szene_\xfc.toml") + field_of_bytes(7, b"name=proxy")
        with tempfile.NamedTemporaryFile(suffix=".hapton") as file:
            file.write(recording_of(setup))
            file.flush()
            (haptics,) = hapton.read_session(file.name)["header"]["haptics"]
        self.assertEqual(haptics["scene"], "/home/a/szene_\ufffd.toml")
        self.assertEqual(haptics["method"], "name=proxy")


if __name__ == "__main__":
    unittest.main()

"""Programs see the material that the stylus carves: with TouchStep, with a live client, and in a recording that begins later."""
import os
import subprocess
import time
import unittest

import numpy as np

import hapton
from live_system import BIN, SOURCE, LiveSystem

CLAY = os.path.join(SOURCE, "scenes", "clay.toml")
# The device moves down into the ball with the first button held, along inside it, and out again.
TRAJECTORY_CSV = """t_s,x_m,y_m,z_m,buttons
0,0,0.1,0,0
0.3,0,0.058,0,1
0.8,0,0.044,0,1
1.3,0.02,0.044,0.004,1
1.6,0.02,0.1,0.004,0
2.4,0.02,0.1,0.004,0
3,0,0.1,0,0
"""


def wait_for(find, seconds=60):
    """The first result of find() that counts as true; after that time, its last one."""
    end = time.monotonic() + seconds
    while True:
        found = find()
        if found or time.monotonic() > end:
            return found
        time.sleep(0.02)


def press_into_clay(steps=400):
    positions = np.tile([0.0, 0.1, 0.0], (steps, 1))
    positions[:, 1] = np.linspace(0.1, 0.045, steps)
    return positions


class CarveTest(unittest.TestCase):
    def test_buttons_carve_in_a_batch(self):
        positions = press_into_clay()
        whole = hapton.TouchStep.from_scene(CLAY)
        firm = whole.step(positions)
        self.assertFalse(firm["carve"].any())
        carved = hapton.TouchStep.from_scene(CLAY)
        soft = carved.step(positions, buttons=1)
        serials = soft["carve"][soft["carve"] > 0]
        self.assertGreater(len(serials), 5)
        np.testing.assert_array_equal(serials, np.arange(1, len(serials) + 1))
        self.assertLess(soft["force_n"][-1, 1], firm["force_n"][-1, 1], "it gives way")
        # buttons may have one number for each position.
        late = hapton.TouchStep.from_scene(CLAY)
        buttons = np.where(np.arange(len(positions)) < 380, 0, 1)
        late_carve = late.step(positions, buttons=buttons)["carve"]
        self.assertFalse(late_carve[:380].any())
        self.assertTrue(late_carve[380:].any())

    def test_what_is_wrong_is_one_clear_error(self):
        touch = hapton.TouchStep.from_scene(CLAY)
        positions = press_into_clay(10)
        for arguments, why in [
            ({"dt_s": -1e-3}, r"^dt_s\[0\] is -0.001; give seconds above 0, at most 1$"),
            ({"dt_s": [1e-3] * 9 + [-1e-3], "buttons": 1}, r"^dt_s\[9\] is -0.001;"),
            ({"dt_s": float("nan")}, r"^dt_s\[0\] is nan;"),
            ({"buttons": -1}, r"^buttons\[0\] is -1; give a whole number of 32 bits"),
            ({"buttons": 1.5}, r"^buttons\[0\] is 1.5; give a whole number of 32 bits"),
            ({"buttons": [1, 0]}, r"^buttons has 2 numbers; give one, or one for each position$"),
        ]:
            with self.subTest(why), self.assertRaisesRegex(ValueError, why):
                touch.step(positions, **arguments)
        self.assertFalse(touch.step(positions)["carve"].any(), "none of them has carved")

    def test_a_recording_that_begins_later_has_what_was_carved_before(self):
        system = LiveSystem()
        self.addCleanup(system.close)
        way = system.path("way.csv")
        with open(way, "w") as file:
            file.write(TRAJECTORY_CSV)
        system.end_io()
        device = ["--bind", system.hub, "--device", "replay", "--loop", "--trajectory", way, "--seconds", "120"]
        system.io = system.start(system.io_log, "io_node", *device)
        system.wait_for(system.io_log, r"^hub on ([0-9.:]+),")
        system.start_haptics("clay.toml")
        client = hapton.Client(system.hub)

        # The stylus goes on carving: each call may give more than the one before.
        def all_carves(of_client):
            carves = of_client.carves()
            return carves if len(carves["radius_m"]) == carves["newest"] > 20 else None

        self.assertIsNotNone(wait_for(lambda: all_carves(client)))
        late = hapton.Client(system.hub)
        late_carves = wait_for(lambda: all_carves(late))
        self.assertIsNotNone(late_carves)
        client_carves = client.carves()
        for name in ("object", "from_m", "to_m", "radius_m"):
            np.testing.assert_array_equal(late_carves[name][:20], client_carves[name][:20])
        self.assertEqual(set(late_carves["object"]), {1})
        without_15 = late.carves(after=15)
        count = len(late_carves["object"]) - 15
        self.assertGreaterEqual(len(without_15["object"]), count)
        for name in ("object", "from_m", "to_m", "radius_m"):
            np.testing.assert_array_equal(without_15[name][:count], late_carves[name][15:])
        client.close()
        late.close()
        system.end_io()
        recording = system.path("later.hapton")
        system.io = system.start(system.io_log, "io_node", *device, "--record", recording)
        system.wait_for(system.io_log, r"^hub on ([0-9.:]+),")
        watcher = hapton.Client(system.hub)
        self.assertTrue(wait_for(lambda: watcher.carves()["newest"] > 20), "the haptics node has not joined again")
        watcher.close()
        system.record_for(4.0, recording)
        system.end_io()
        session = hapton.read_session(recording)
        before = np.isnan(session["carves"]["t_s"])
        self.assertGreater(before.sum(), 20)
        np.testing.assert_array_equal(session["carves"]["serial"], np.arange(1, len(before) + 1))
        self.assertEqual(np.nanmin(session["carve_serial"]), before.sum())
        replayed = subprocess.run([os.path.join(BIN, "hapton"), "session", "replay", recording], capture_output=True, text=True)
        self.assertEqual(replayed.returncode, 0, replayed.stdout + replayed.stderr)
        self.assertRegex(replayed.stdout, r"[1-9][0-9]* in contact; [1-9][0-9]{2,} compared bit for bit, 0 different")


if __name__ == "__main__":
    unittest.main()

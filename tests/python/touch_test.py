"""hapton.TouchStep: batches on NumPy arrays."""
import os
import tempfile
import threading
import time
import unittest

import numpy as np

import hapton


def make_wall():
    return hapton.Mesh([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2], [0, 2, 3]])


def make_ball(n=24, radius=0.05):
    """A closed sphere of latitude bands, normals outward."""
    vertices = [[0, 0, radius]]
    for i in range(1, n):
        for j in range(2 * n):
            a, b = np.pi * i / n, np.pi * j / n
            vertices.append([radius * np.sin(a) * np.cos(b), radius * np.sin(a) * np.sin(b), radius * np.cos(a)])
    vertices.append([0, 0, -radius])
    ring = lambda i, j: 1 + (i - 1) * 2 * n + j % (2 * n)
    triangles = []
    for j in range(2 * n):
        triangles.append([0, ring(1, j), ring(1, j + 1)])
        triangles.append([len(vertices) - 1, ring(n - 1, j + 1), ring(n - 1, j)])
        for i in range(1, n - 1):
            triangles.append([ring(i, j), ring(i + 1, j), ring(i + 1, j + 1)])
            triangles.append([ring(i, j), ring(i + 1, j + 1), ring(i, j + 1)])
    return hapton.Mesh(vertices, triangles)


def press(depth_m, count=200, above_m=0.005):
    """Straight down along z through the origin."""
    positions = np.zeros((count, 3))
    positions[:, 2] = np.linspace(above_m, -depth_m, count)
    return positions


class TouchTest(unittest.TestCase):
    def test_a_wall_pushes_back_as_hooke_says(self):
        touch = hapton.TouchStep(make_wall(), hapton.Material(stiffness_n_per_m=500.0))
        positions = press(0.004)
        felt = touch.step(positions)
        self.assertEqual(felt["force_n"].shape, (200, 3))
        self.assertEqual(felt["proxy_m"].shape, (200, 3))
        depth = np.maximum(0.0, -positions[:, 2])
        np.testing.assert_allclose(felt["force_n"][:, 2], 500.0 * depth, atol=1e-3)
        np.testing.assert_array_equal(felt["contact"], felt["force_n"][:, 2] > 0)
        np.testing.assert_array_equal(felt["object"][felt["contact"]], 0)
        np.testing.assert_array_equal(felt["object"][~felt["contact"]], -1)
        self.assertTrue((felt["step_ns"] >= 0).all())
        # The proxy stays on the surface.
        self.assertLess(np.abs(felt["proxy_m"][felt["contact"], 2]).max(), 1e-5)

    def test_batches_give_what_single_steps_give(self):
        ball, positions = make_ball(), press(-0.045, above_m=0.06) + [0.001, 0.002, 0]
        whole = hapton.TouchStep(ball).step(positions)
        touch = hapton.TouchStep(ball)
        single = np.concatenate([touch.step(p)["force_n"] for p in positions])
        np.testing.assert_array_equal(whole["force_n"], single)
        self.assertTrue(whole["contact"].any())

    def test_every_method_touches_a_ball(self):
        for method in hapton.methods():
            with self.subTest(method):
                touch = hapton.TouchStep(make_ball(), method=method)
                felt = touch.step(press(-0.045, above_m=0.06))
                self.assertGreater(felt["force_n"][-1, 2], 0.5)
                self.assertFalse(felt["contact"][0])
                self.assertTrue(touch.describe())
        self.assertIn("proxy", hapton.methods())

    def test_reset_forgets_contact(self):
        touch = hapton.TouchStep(make_wall())
        self.assertTrue(touch.step(press(0.004))["contact"][-1])
        touch.reset([0, 0, -0.1])
        self.assertFalse(touch.step([[0, 0, -0.1001]])["contact"][0])

    def test_objects_have_their_own_material(self):
        far = hapton.Mesh([[2, -1, 0], [4, -1, 0], [4, 1, 0], [2, 1, 0]], [[0, 1, 2], [0, 2, 3]])
        touch = hapton.TouchStep([make_wall(), (far, hapton.Material(stiffness_n_per_m=100.0))])
        soft = touch.step(press(0.004) * [1, 1, 1] + [3, 0, 0])
        self.assertEqual(soft["object"][-1], 1)
        self.assertAlmostEqual(soft["force_n"][-1, 2], 0.4, places=3)

    def test_the_scene_has_a_pose(self):
        touch = hapton.TouchStep(make_wall())
        pose = np.eye(4)
        pose[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]  # its z axis points along y
        pose[:3, 3] = [0, 0.5, 0]
        positions = press(0.004)[:, [0, 2, 1]] + [0, 0.5, 0]
        felt = touch.step(positions, scene_pose=pose)
        np.testing.assert_allclose(felt["force_n"][-1], [0, 4.0, 0], atol=0.01)
        with self.assertRaisesRegex(ValueError, "scene_pose is not a rigid pose"):
            touch.step(positions, scene_pose=2 * pose)
        with self.assertRaisesRegex(ValueError, r"scene_pose has shape \(3, 3\)"):
            touch.step(positions, scene_pose=np.eye(3))

    def test_scene_files_bring_materials_and_effects(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "wall.obj"), "w") as file:
                file.write("v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3\nf 1 3 4\n")
            with open(os.path.join(folder, "a.toml"), "w") as file:
                file.write("""
[[object]]
mesh = "wall.obj"
unit = "m"
material = "soft"
[material.soft]
stiffness_n_per_m = 250.0
[[effect]]
type = "spring"
position_m = [0.0, 0.0, 0.0]
stiffness_n_per_m = 50.0
max_force_n = 3.0
""")
            touch = hapton.TouchStep.from_scene(os.path.join(folder, "a.toml"))
        felt = touch.step(press(0.004))
        np.testing.assert_allclose(felt["force_n"][0], [0, 0, -50.0 * 0.005], atol=1e-12)
        np.testing.assert_allclose(felt["force_n"][-1], [0, 0, (250.0 + 50.0) * 0.004], atol=1e-3)
        with self.assertRaisesRegex(ValueError, "nowhere.toml"):
            hapton.TouchStep.from_scene("nowhere.toml")

    def test_samples_that_are_not_finite_give_no_force(self):
        touch = hapton.TouchStep(make_wall())
        positions = press(0.004)
        positions[150] = np.nan
        felt = touch.step(positions)
        np.testing.assert_array_equal(felt["force_n"][150], 0.0)
        self.assertGreater(felt["force_n"][151, 2], 0.0)

    def test_settings_are_those_of_the_method(self):
        touch = hapton.TouchStep(make_wall(), probe_radius_m=0.002)
        felt = touch.step(press(0.001))
        self.assertAlmostEqual(felt["force_n"][-1, 2], 3.0, places=2)
        with self.assertRaisesRegex(TypeError, "there is no setting 'probe_radius'; choose from: .*probe_radius_m"):
            hapton.TouchStep(make_wall(), probe_radius=0.002)
        with self.assertRaisesRegex(TypeError, "shading has the wrong type"):
            hapton.TouchStep(make_wall(), shading="much")
        with self.assertRaisesRegex(ValueError, "'magic' is not known"):
            hapton.TouchStep(make_wall(), method="magic")

    def test_rejects_what_cannot_be(self):
        touch = hapton.TouchStep(make_wall())
        with self.assertRaisesRegex(ValueError, r"positions has shape \(4, 2\)"):
            touch.step(np.zeros((4, 2)))
        with self.assertRaisesRegex(ValueError, "dt_s has 2 numbers"):
            touch.step(np.zeros((4, 3)), dt_s=[0.001, 0.001])
        with self.assertRaisesRegex(ValueError, r"dt_s\[0\] is 0"):
            touch.step(np.zeros((4, 3)), dt_s=0.0)
        with self.assertRaisesRegex(ValueError, "stiffness_n_per_m"):
            hapton.Material(stiffness_n_per_m=-1.0)
        with self.assertRaisesRegex(ValueError, "friction_dynamic"):
            hapton.Material(friction_dynamic=0.5)
        with self.assertRaisesRegex(ValueError, "no objects"):
            hapton.TouchStep([])
        with self.assertRaisesRegex(ValueError, "something else than a Mesh"):
            hapton.TouchStep([1])

    def test_other_threads_run_during_a_batch(self):
        touch = hapton.TouchStep(make_ball())
        positions = np.tile(press(-0.045, above_m=0.06), (2000, 1))

        def turns_in_the_middle():
            times = []

            def run_batch():
                times.append(time.perf_counter())
                touch.step(positions)
                times.append(time.perf_counter())

            batch = threading.Thread(target=run_batch)
            batch.start()
            turns = []
            while batch.is_alive():
                turns.append(time.perf_counter())
            batch.join()
            begin, end = times
            return sum(0.25 < (turn - begin) / (end - begin) < 0.75 for turn in turns)

        # With the lock held, this loop would turn only at the beginning and the end. A busy machine may keep this thread from turning, too.
        self.assertTrue(any(turns_in_the_middle() > 10 for _ in range(20)))

    def test_threads_may_share_a_step(self):
        touch = hapton.TouchStep(make_ball())
        positions = press(-0.045, above_m=0.06, count=5000)
        felt = []
        threads = [threading.Thread(target=lambda: felt.append(touch.step(positions))) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(felt), 4)
        for each in felt:
            np.testing.assert_array_equal(each["force_n"][-1], felt[0]["force_n"][-1])


if __name__ == "__main__":
    unittest.main()

"""Tests hapton.DeformStep: a surface that a program deforms."""
import threading
import unittest

import numpy as np

import hapton


def make_sheet(n=9, side=0.08):
    x, y = np.meshgrid(np.linspace(-side / 2, side / 2, n), np.linspace(-side / 2, side / 2, n))
    vertices = np.column_stack([x.ravel(), y.ravel(), np.zeros(n * n)])
    at = np.arange(n * n).reshape(n, n)
    a, b, c, d = at[:-1, :-1].ravel(), at[:-1, 1:].ravel(), at[1:, 1:].ravel(), at[1:, :-1].ravel()
    return hapton.Mesh(vertices, np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])]))


def raised(mesh, by):
    return mesh.vertices + [0, 0, by]


class DeformTest(unittest.TestCase):
    def test_a_sheet_that_comes_pushes_a_hand_that_holds_still(self):
        mesh = make_sheet()
        surface = hapton.DeformStep(mesh, 0.02, hapton.Material(stiffness_n_per_m=500))
        hand = np.tile([0.001, 0.002, 0.005], (200, 1))
        self.assertFalse(surface.step(hand[:1])["contact"].any())
        self.assertAlmostEqual(surface.set_shape(raised(mesh, 0.01), over_s=0.1), 0.1)
        felt = surface.step(hand)
        for name, shape in [("force_n", (200, 3)), ("proxy_m", (200, 3)), ("contact", (200,)), ("step_ns", (200,))]:
            self.assertEqual(felt[name].shape, shape, name)
        height = np.minimum(0.01, 0.1 * 1e-3 * np.arange(1, 201))
        np.testing.assert_allclose(felt["force_n"][:, 2], 500 * np.maximum(0.0, height - 0.005), atol=1e-3)
        np.testing.assert_allclose(surface.vertices, raised(mesh, 0.01), atol=1e-12)
        self.assertIn("81 vertices", surface.describe())

    def test_no_vertex_is_faster_than_a_quarter_of_a_metre_a_second(self):
        mesh = make_sheet()
        surface = hapton.DeformStep(mesh, 0.02)
        self.assertAlmostEqual(surface.set_shape(raised(mesh, 0.01)), 0.04, places=9)
        felt = surface.step(np.tile([0.001, 0.002, 0.005], (100, 1)))
        self.assertLessEqual(np.diff(felt["force_n"][:, 2]).max(), 1000 * 0.25e-3 * (1 + 1e-6) + 1e-6)
        self.assertAlmostEqual(felt["force_n"][-1, 2], 5.0, places=3)

    def test_the_newest_shape_that_waits_counts(self):
        mesh = make_sheet()
        surface = hapton.DeformStep(mesh, 0.02)
        surface.step([0, 0, 0.015])
        for by in (0.01, -0.01, 0.004):
            surface.set_shape(raised(mesh, by), over_s=0.05)
        surface.step(np.tile([0, 0, 0.015], (60, 1)))
        np.testing.assert_allclose(surface.vertices, raised(mesh, 0.004), atol=1e-12)

    def test_shapes_may_come_from_another_thread(self):
        mesh = make_sheet()
        surface = hapton.DeformStep(mesh, 0.02)
        stop = threading.Event()

        def stream():
            i = 0
            while not stop.is_set():
                surface.set_shape(raised(mesh, 0.003 * np.sin(0.3 * i)), over_s=0.02)
                i += 1

        thread = threading.Thread(target=stream)
        thread.start()
        forces = [surface.step(np.tile([0.001, 0.002, -0.002], (100, 1)))["force_n"] for _ in range(20)]
        stop.set()
        thread.join()
        steps = np.diff(np.vstack(forces)[:, 2])
        self.assertLessEqual(np.abs(steps).max(), 1000 * 0.25e-3 * (1 + 1e-6) + 1e-6)

    def test_what_cannot_be_is_one_line_and_changes_nothing(self):
        mesh = make_sheet()
        surface = hapton.DeformStep(mesh, 0.02)
        folded = mesh.vertices.copy()
        folded[:, 0] = -np.abs(folded[:, 0]) * 0.2
        broken = mesh.vertices.copy()
        broken[3, 1] = np.nan
        for vertices, what in [
            (mesh.vertices[:-1], "80 vertices were given; the mesh has 81"),
            (raised(mesh, 0.03), "vertex 0 is 0.03 m from where it is at rest; the largest distance is the reach, 0.02 m"),
            (broken, "not finite"),
        ]:
            with self.assertRaisesRegex(ValueError, what):
                surface.set_shape(vertices)
        with self.assertRaisesRegex(ValueError, "touch or nearly touch another part"):
            hapton.DeformStep(mesh, 1.0).set_shape(folded)
        for over_s in (-1.0, np.nan):
            with self.assertRaisesRegex(ValueError, "over_s"):
                surface.set_shape(mesh.vertices, over_s=over_s)
        for reach in (0.0, -1.0, np.nan, np.inf):
            with self.assertRaisesRegex(ValueError, "reach"):
                hapton.DeformStep(mesh, reach)
        with self.assertRaisesRegex(ValueError, "dt_s"):
            surface.step([0, 0, 0], dt_s=0.0)
        surface.step([0, 0, 0.1])
        np.testing.assert_array_equal(surface.vertices, mesh.vertices)
        self.assertEqual(surface.step([np.nan, 0, 0])["force_n"].tolist(), [[0, 0, 0]])


if __name__ == "__main__":
    unittest.main()

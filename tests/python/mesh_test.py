"""hapton.Mesh, load_mesh, mesh_info."""
import os
import tempfile
import unittest

import numpy as np

import hapton

MESHES = os.path.join(os.environ["HAPTON_SOURCE_DIR"], "meshes")
TETRAHEDRON = "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


class MeshTest(unittest.TestCase):
    def test_holds_what_it_was_given(self):
        vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=np.float32)
        mesh = hapton.Mesh(vertices, [[0, 1, 2]])
        np.testing.assert_array_equal(mesh.vertices, vertices)
        np.testing.assert_array_equal(mesh.triangles, [[0, 1, 2]])
        self.assertEqual(repr(mesh), "<hapton.Mesh: 3 vertices, 1 triangles>")

    def test_takes_indices_of_any_type_that_are_whole(self):
        for kind in (np.uint8, np.uint32, np.int64, np.float32, float):
            mesh = hapton.Mesh(np.eye(3), np.array([[0, 1, 2]], dtype=kind))
            np.testing.assert_array_equal(mesh.triangles, [[0, 1, 2]])

    def test_gives_copies(self):
        mesh = hapton.Mesh(np.eye(3), [[0, 1, 2]])
        mesh.vertices[0, 0] = 7.0
        self.assertEqual(mesh.vertices[0, 0], 1.0)

    def test_rejects_what_is_no_mesh(self):
        points = np.zeros((3, 3))
        for vertices, triangles, word in [
            (np.zeros((3, 2)), [[0, 1, 2]], r"vertices has shape \(3, 2\)"),
            (np.full((3, 3), np.nan), [[0, 1, 2]], r"vertices\[0\] is not finite"),
            (points, [[0, 1, 3]], r"triangles\[0\] names vertex 3; there are 3"),
            (points, [[0, 1, -1]], "names vertex -1"),
            (points, [[0, 1, 1.5]], r"triangles\[0\] names vertex 1.5"),
            (points, [[0, 1, np.nan]], "names vertex nan"),
            (points, np.zeros((0, 3), dtype=int), "triangles is empty"),
            (points, [0, 1, 2], "must have the shape"),
        ]:
            with self.subTest(word), self.assertRaisesRegex(ValueError, word):
                hapton.Mesh(vertices, triangles)

    def test_reads_a_file_in_its_unit(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "part.obj")
            with open(path, "w") as file:
                file.write(TETRAHEDRON)
            mesh = hapton.load_mesh(path, "mm")
            self.assertAlmostEqual(mesh.vertices.max(), 0.01)
            self.assertEqual(len(mesh.triangles), 4)
            info = hapton.mesh_info(path, unit="mm")
            self.assertEqual(info["triangles"], 4)

    def test_names_the_file_or_unit_that_is_wrong(self):
        with self.assertRaisesRegex(ValueError, "nowhere.obj"):
            hapton.load_mesh("nowhere.obj")
        with self.assertRaisesRegex(ValueError, "'miles'"):
            hapton.load_mesh(os.path.join(MESHES, "relief.obj"), unit="miles")
        with self.assertRaisesRegex(ValueError, "nowhere.stl"):
            hapton.mesh_info("nowhere.stl")


if __name__ == "__main__":
    unittest.main()

"""hapton.ToolStep: batches of poses of a rigid tool."""
import os
import re
import tempfile
import unittest
import warnings

import numpy as np

import hapton

SOURCE = os.environ["HAPTON_SOURCE_DIR"]


def make_floor(side=1.0):
    return hapton.Mesh([[-side, -side, 0], [side, -side, 0], [side, side, 0], [-side, side, 0]], [[0, 1, 2], [0, 2, 3]])


def make_cube(half=0.01, shift=(0, 0, 0)):
    """Its grip point is the origin."""
    corners = [[x, y, z] for x in (-half, half) for y in (-half, half) for z in (-half, half)]
    sides = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    return hapton.Mesh(np.array(corners) + shift, sides)


def straight_down(low, high=0.03, count=150):
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, 2, 3] = np.linspace(high, low, count)
    return poses


class ToolTest(unittest.TestCase):
    def test_a_floor_pushes_a_cube_back_as_hooke_says(self):
        tool = hapton.ToolStep(make_cube(), make_floor(), hapton.Material(stiffness_n_per_m=500.0))
        poses = straight_down(0.006)
        felt = tool.step(poses)
        for name, shape in [("force_n", (150, 3)), ("torque_nm", (150, 3)), ("proxy", (150, 4, 4)), ("contact", (150,)), ("step_ns", (150,))]:
            self.assertEqual(felt[name].shape, shape, name)
        depth = np.maximum(0.0, 0.01 - poses[:, 2, 3])
        np.testing.assert_allclose(felt["force_n"][:, 2], 500.0 * depth, atol=0.02)
        np.testing.assert_allclose(felt["force_n"][:, :2], 0.0, atol=1e-3)
        np.testing.assert_allclose(felt["torque_nm"], 0.0, atol=1e-4)
        np.testing.assert_array_equal(felt["contact"][depth > 1e-4], True)
        self.assertFalse(felt["contact"][0])
        self.assertFalse(felt["blocked"].any())
        # The tool is drawn on the floor, upright.
        np.testing.assert_allclose(felt["proxy"][-1][:3, 3], [0, 0, 0.01], atol=1e-4)
        np.testing.assert_allclose(felt["proxy"][-1][:3, :3], np.eye(3), atol=1e-4)
        np.testing.assert_array_equal(felt["proxy"][0], poses[0])

    def test_one_held_beside_its_middle_is_turned(self):
        tool = hapton.ToolStep(make_cube(shift=(0.03, 0, 0)), make_floor(), hapton.Material(stiffness_n_per_m=500.0))
        felt = tool.step(straight_down(0.006))
        # The floor pushes up at x > 0: the torque turns the tool about -y.
        self.assertLess(felt["torque_nm"][-1, 1], -1e-3)
        self.assertGreater(felt["force_n"][-1, 2], 0.1)

    def test_batches_give_what_single_poses_give(self):
        poses = straight_down(0.004)
        turn = np.linspace(0, 0.4, len(poses))
        poses[:, 0, 0] = poses[:, 2, 2] = np.cos(turn)
        poses[:, 0, 2], poses[:, 2, 0] = np.sin(turn), -np.sin(turn)
        whole = hapton.ToolStep(make_cube(), make_floor()).step(poses)
        tool = hapton.ToolStep(make_cube(), make_floor())
        for name in ("force_n", "torque_nm", "proxy"):
            with self.subTest(name):
                tool.reset(poses[0])
                single = np.concatenate([tool.step(pose)[name] for pose in poses])
                np.testing.assert_array_equal(whole[name], single)
        self.assertTrue(whole["contact"].any())

    def test_the_scene_has_a_pose(self):
        tool = hapton.ToolStep(make_cube(), make_floor())
        pose = np.eye(4)
        pose[2, 3] = 0.1
        poses = straight_down(0.106, high=0.13)
        np.testing.assert_allclose(tool.step(poses, scene_pose=pose)["force_n"][-1], [0, 0, 4.0], atol=0.05)

    def test_friction_holds_the_tool_at_its_place(self):
        sideways = np.tile(np.eye(4), (50, 1, 1))
        sideways[:, 0, 3] = np.linspace(0, 0.001, 50)
        sideways[:, 2, 3] = 0.006
        forces = []
        for friction in (0.0, 0.5):
            material = hapton.Material(friction_static=friction, friction_dynamic=friction)
            tool = hapton.ToolStep(make_cube(), [(make_floor(), material)])
            tool.step(straight_down(0.006))
            forces.append(tool.step(sideways)["force_n"][-1, 0])
        self.assertAlmostEqual(forces[0], 0.0, places=3)
        self.assertLess(forces[1], -0.5)

    def test_scene_files_have_their_own_tool(self):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tool = hapton.ToolStep.from_scene(os.path.join(SOURCE, "scenes", "pegs.toml"))
            # The lower end of the peg, 20 mm below its middle, is pressed onto the upper side of the blocks, at z = 10 mm.
            poses = straight_down(0.0285, high=0.04)
            poses[:, :2, 3] = [-0.026, 0.012]
            felt = tool.step(poses)
            self.assertFalse(felt["contact"][0])
            self.assertGreater(felt["force_n"][-1, 2], 0.1)
            peg = os.path.join(SOURCE, "meshes", "peg.obj")
            other = hapton.ToolStep.from_scene(os.path.join(SOURCE, "scenes", "thin_wall.toml"), tool=peg, tool_unit="mm", grip="centre")

            def triangles_of(step):
                return int(re.search(r"tool: ([0-9]+) triangles", step.describe()).group(1))

            self.assertEqual(triangles_of(tool), triangles_of(other))
            self.assertNotEqual(triangles_of(tool), triangles_of(hapton.ToolStep(make_cube(), make_floor())))
            # The wall's upper side is at z = 0.05 mm.
            felt = other.step(straight_down(0.0195, high=0.03))
            self.assertFalse(felt["contact"][0])
            self.assertGreater(felt["force_n"][-1, 2], 0.1)
        with self.assertRaisesRegex(ValueError, r"thin_wall.toml has no \[tool\]; give tool="):
            hapton.ToolStep.from_scene(os.path.join(SOURCE, "scenes", "thin_wall.toml"))
        with self.assertRaisesRegex(ValueError, "nowhere.toml"):
            hapton.ToolStep.from_scene("nowhere.toml", tool="a.obj")

    def test_what_a_tool_does_not_have_is_said(self):
        with self.assertWarnsRegex(UserWarning, "of surfaces, a rigid tool has friction, damping and viscosity"):
            hapton.ToolStep(make_cube(), make_floor(), hapton.Material(two_sided=False))

    def test_damping_acts_along_the_normal(self):
        down = straight_down(0.0, count=300)
        speed = (down[-2, 2, 3] - down[-1, 2, 3]) / 1e-3
        forces = [
            hapton.ToolStep(make_cube(), make_floor(), hapton.Material(damping_ns_per_m=damping)).step(down)["force_n"][-1]
            for damping in (0.0, 2.0)
        ]
        np.testing.assert_allclose(forces[1] - forces[0], [0, 0, 2.0 * speed], atol=1e-3 * speed)

    def test_effects_in_free_space_act_at_the_grip(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "a.toml"), "w") as file:
                file.write(f"""
[tool]
mesh = "{SOURCE}/meshes/peg.obj"
unit = "mm"
[[object]]
mesh = "{SOURCE}/meshes/peg.obj"
unit = "mm"
position_m = [0.0, 0.0, -1.0]
[[effect]]
type = "spring"
position_m = [0.0, 0.0, 0.0]
stiffness_n_per_m = 50.0
max_force_n = 3.0
""")
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                tool = hapton.ToolStep.from_scene(os.path.join(folder, "a.toml"))
            pose = np.tile(np.eye(4), (3, 1, 1))
            pose[:, :3, 3] = [0.01, -0.02, 0.03]
            felt = tool.step(pose)
            np.testing.assert_allclose(felt["force_n"], np.tile([-0.5, 1.0, -1.5], (3, 1)), rtol=1e-12)
            np.testing.assert_array_equal(felt["torque_nm"], 0.0)
            self.assertTrue(felt["contact"].all())
            # The scene turns by a quarter about z and brings its spring along.
            turned = np.array([[0.0, -1.0, 0, 0.1], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
            np.testing.assert_allclose(tool.step(pose[0], scene_pose=turned)["force_n"][0], [4.5, 1.0, -1.5] / np.linalg.norm([4.5, 1.0, -1.5]) * 3, rtol=1e-12)

    def test_poses_that_are_not_finite_give_no_force(self):
        tool = hapton.ToolStep(make_cube(), make_floor())
        poses = straight_down(0.006)
        poses[0] = poses[140] = np.nan
        felt = tool.step(poses)
        np.testing.assert_array_equal(felt["force_n"][[0, 140]], 0.0)
        self.assertGreater(felt["force_n"][[139, 141], 2].min(), 0.5)

    def test_rejects_what_cannot_be(self):
        tool = hapton.ToolStep(make_cube(), make_floor())
        for make, word in [
            (lambda: tool.step(np.zeros((3, 3))), r"poses has shape \(3, 3\); give \(n, 4, 4\)"),
            (lambda: tool.step(2 * straight_down(0.01)), r"poses\[0\] is not a rigid pose"),
            (lambda: tool.reset(np.zeros((4, 4))), "pose is not a rigid pose"),
            (lambda: hapton.ToolStep(make_cube(), []), "there are no objects"),
            (lambda: hapton.ToolStep(make_cube(), make_floor(), rotational_stiffness_nm_per_rad=-1), "rotational_stiffness_nm_per_rad is -1"),
            (lambda: hapton.ToolStep(make_cube(half=0.0), make_floor()), "no surface"),
        ]:
            with self.subTest(word), self.assertRaisesRegex(ValueError, word):
                make()


if __name__ == "__main__":
    unittest.main()

"""hapton.fields: each law against its formula."""
import unittest

import numpy as np

from hapton import fields


def force_at(field, point, velocity=(0, 0, 0), t_s=0.1):
    """The force at the end of a straight path, t_s after its beginning."""
    dt_s = 1e-3
    steps = round(t_s / dt_s)
    path = np.array(point) + np.outer(np.arange(-steps, 1) * dt_s, velocity)
    return fields.evaluate([field], path, dt_s)[-1]


class FieldsTest(unittest.TestCase):
    def test_spring(self):
        np.testing.assert_allclose(force_at(fields.spring([0, 0.01, 0], 100.0), [0.02, 0.01, 0]), [-2.0, 0, 0])

    def test_viscous(self):
        np.testing.assert_allclose(force_at(fields.viscous(3.0), [0, 0, 0], [0.2, 0, -0.1]), [-0.6, 0, 0.3], rtol=1e-6)

    def test_constant(self):
        np.testing.assert_allclose(force_at(fields.constant([0, -1.5, 0]), [9, 9, 9]), [0, -1.5, 0])

    def test_mass_is_towed_through_its_damper(self):
        t_s = np.arange(1, 501) * 1e-3
        acceleration = np.array([1.5, 0.0, -0.5])
        path = 0.5 * np.vstack([[0.0], t_s[:, None]]) ** 2 * acceleration
        np.testing.assert_allclose(fields.evaluate([fields.mass(0.2)], path)[-1], -0.2 * acceleration, rtol=1e-6)
        # Full speed at once: the mass follows as 1 - exp(-t / filter), and the mean of eight differences is complete after eight.
        path = np.vstack([[0.0], t_s[:, None]]) * np.array([0.3, 0.0, 0.0])
        force_n = fields.evaluate([fields.mass(0.1, filter_s=0.05)], path)[8:, 0]
        np.testing.assert_allclose(force_n[1:] / force_n[:-1], np.exp(-1e-3 / 0.05), rtol=1e-6)
        self.assertLess(np.sum(force_n) * 1e-3 / (0.1 * 0.3), -0.85)  # most of its momentum after those eight
        self.assertLessEqual(np.abs(fields.evaluate([fields.mass(5.0, max_force_n=2.0)], path)).max(), 2.0 + 1e-12)

    def test_sine(self):
        np.testing.assert_allclose(force_at(fields.sine([0, 0, 2], 0.7, 2.5), [0, 0, 0], t_s=0.1), [0, 0, 0.7], rtol=1e-6)

    def test_wall_pushes_out_and_never_pulls(self):
        wall = fields.wall([0, 0.01, 0], [0, 1, 0], stiffness_n_per_m=500.0, damping_ns_per_m=2.0)
        np.testing.assert_allclose(force_at(wall, [0.3, 0.006, 0]), [0, 2.0, 0])
        np.testing.assert_allclose(force_at(wall, [0, 0.006, 0], [0, -0.1, 0]), [0, 2.2, 0], rtol=1e-6)
        np.testing.assert_array_equal(force_at(wall, [0, 0.011, 0]), 0)
        np.testing.assert_array_equal(force_at(wall, [0, 0.0099, 0], [0, 1.0, 0]), 0)

    def test_channel_leaves_its_line_free(self):
        channel = fields.channel([0, 0, 0.01], [1, 0, 0], stiffness_n_per_m=300.0, damping_ns_per_m=1.0)
        np.testing.assert_allclose(force_at(channel, [5.0, 0.002, 0.01]), [0, -0.6, 0], atol=1e-9)
        np.testing.assert_allclose(force_at(channel, [5.0, 0, 0.01], [3.0, 0, 0]), 0, atol=1e-6)

    def test_pulse_is_a_half_sine_after_its_delay(self):
        pulse = fields.pulse([2, 0, 0], duration_s=0.1, delay_s=0.05)
        for t_s, expected in [(0.04, 0.0), (0.1, 2.0), (0.2, 0.0)]:
            np.testing.assert_allclose(force_at(pulse, [0, 0, 0], t_s=t_s), [expected, 0, 0], atol=1e-9)

    def test_fields_add_up_and_each_is_bounded(self):
        both = fields.evaluate([fields.spring([0, 0, 0], 1e5, max_force_n=3.0), fields.constant([0, 1, 0])], [[1, 0, 0]])
        np.testing.assert_allclose(both, [[-3.0, 1.0, 0]])
        self.assertEqual(fields.evaluate([], np.ones((4, 3))).shape, (4, 3))
        np.testing.assert_array_equal(fields.evaluate([fields.constant([1, 1, 1])], [[np.nan, 0, 0]]), 0)

    def test_time_goes_on_and_velocity_stays_where_positions_are_missing(self):
        laws = [fields.viscous(3.0), fields.sine([0, 0, 1], 0.7, 2.5), fields.pulse([0, 2, 0], duration_s=0.1, delay_s=0.02)]
        path = np.outer(np.arange(100) * 1e-3, [0.2, 0, 0])
        gaps = path.copy()
        gaps[[0, 30, 31, 32, 60]] = np.nan
        whole, felt = fields.evaluate(laws, path), fields.evaluate(laws, gaps)
        np.testing.assert_array_equal(felt[[0, 30, 31, 32, 60]], 0)
        present = np.setdiff1d(np.arange(10, 100), [30, 31, 32, 60])
        np.testing.assert_allclose(felt[present], whole[present], atol=1e-9)

    def test_expression_is_its_formula_of_place_velocity_and_time(self):
        law = fields.expression("-k * x + sin(pi * t)", "x > 0 ? 0.5 : -0.5", "-b * vz", k=40, b=2)
        np.testing.assert_allclose(force_at(law, [0.02, 0, 0], [0, 0, 0.1], t_s=0.5), [-0.8 + 1.0, 0.5, -0.2], rtol=1e-6)
        wild = fields.expression("1e6 * x", "0", "1 / z", max_force_n=2.0)
        np.testing.assert_allclose(np.linalg.norm(force_at(wild, [1, 0, 1])), 2.0)
        np.testing.assert_array_equal(force_at(wild, [1, 0, 0]), 0)  # 1 / 0
        assigning = fields.expression("x = 3", "x", "0")
        np.testing.assert_allclose(force_at(assigning, [1, 0, 0]), [3, 1, 0])
        # One field in two sums at once: each has its own variables.
        np.testing.assert_allclose(fields.evaluate([law, law], [[0.02, 0, 0]]), 2 * fields.evaluate([law], [[0.02, 0, 0]]))

    def test_rejects_what_cannot_be(self):
        for make, word in [
            (lambda: fields.spring([0, 0], 100.0), "centre_m has shape"),
            (lambda: fields.spring([0, 0, 0], -1.0), "stiffness_n_per_m is -1"),
            (lambda: fields.wall([0, 0, 0], [0, 0, 0]), "normal is zero"),
            (lambda: fields.constant([np.inf, 0, 0]), "not finite"),
            (lambda: fields.pulse([1, 0, 0], duration_s=0.0), "duration_s is 0"),
            (lambda: fields.mass(0.1, filter_s=0.001), "filter_s is 0.001"),
            (lambda: fields.mass(-0.1), "mass_kg is -0.1"),
            (lambda: fields.viscous(float("nan")), "damping_ns_per_m is nan"),
            (lambda: fields.expression("-k * x", "0", "0"), 'fx = "-k \\* x": .*"k"'),
            (lambda: fields.expression("0", "0", "2 +"), 'fz = "2 \\+"'),
            (lambda: fields.expression("0", "", "0"), 'fy = ""'),
            (lambda: fields.expression("x", "0", "0", k=np.nan), "k is nan"),
            (lambda: fields.expression("x", "0", "0", k="soft"), "the constant k is not a number"),
            (lambda: fields.expression("x", "0", "0", **{"2k": 1.0}), "'2k' cannot name a constant"),
            (lambda: fields.expression("x", "0", "0", vx=1.0), "constant vx has the name"),
            (lambda: fields.expression("x", "0", "0", pi=3.0), "constant pi has the name"),
            (lambda: fields.expression("x", "0", "0", sin=1.0), "constant sin has the name"),
            (lambda: fields.expression("x" * 1001, "0", "0"), "1001 letters"),
        ]:
            with self.subTest(word), self.assertRaisesRegex(ValueError, word):
                make()


if __name__ == "__main__":
    unittest.main()

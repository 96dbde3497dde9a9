"""hapton.run_loop, run_bench and read_table: figures of the commands as arrays."""
import os
import tempfile
import unittest

import numpy as np

import hapton

HAPTON = os.path.join(os.environ["HAPTON_BIN_DIR"], "hapton")


class ResultsTest(unittest.TestCase):
    def test_a_grid_of_loops_is_arrays(self):
        grid = hapton.run_loop("zwidth", program=HAPTON, device="touch", hand="off", delay=[0, 5, 20])
        np.testing.assert_array_equal(grid["inputs_delay_ms"], [0, 5, 20])
        self.assertTrue((np.diff(grid["stable_stiffness_n_per_m"]) < 0).all())
        self.assertTrue((grid["passive_stiffness_n_per_m"] > 0).all())
        self.assertTrue((np.diff(grid["stable_mass_kg"]) < 0).all())
        self.assertEqual(list(grid["inputs_device"]), ["touch"] * 3)
        one = hapton.run_loop("zwidth", program=HAPTON, device="touch")
        self.assertEqual(one["stable_stiffness_n_per_m"].shape, (1,))

    def test_a_press_has_its_samples(self):
        press = hapton.run_loop("press", program=HAPTON, device="touch", stiffness=500)
        samples = press["samples"]
        self.assertGreater(len(samples["t_s"]), 1000)
        self.assertEqual({column.shape for column in samples.values()}, {samples["t_s"].shape})
        self.assertTrue(np.isfinite(press["depth_m"]))

    def test_lists_within_an_answer_are_arrays(self):
        velocity = hapton.run_loop("velocity", program=HAPTON, device="touch")
        tables = [value for value in velocity.values() if isinstance(value, dict)]
        self.assertEqual(len(tables), 1)
        self.assertGreater(len(next(iter(tables[0].values()))), 5)

    def test_a_benchmark_gives_its_tables(self):
        effects = hapton.run_bench("effects", program=HAPTON, steps=1000)["effects"]
        self.assertIn("mass", list(effects["effect"]))
        self.assertTrue((effects["mean_ns"] > 0).all())

    def test_a_table_has_numbers_and_text(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.csv")
            with open(path, "w") as file:
                file.write('# a comment\nname,x_m\n"a, b",1.5\nc,\n')
            table = hapton.read_table(path)
            self.assertEqual(list(table["name"]), ["a, b", "c"])
            np.testing.assert_array_equal(table["x_m"], [1.5, np.nan])
            with open(path, "a") as file:
                file.write("d,1,2\n")
            with self.assertRaisesRegex(ValueError, "row 4 has 3 cells and the header 2"):
                hapton.read_table(path)

    def test_what_the_command_says_is_what_is_raised(self):
        with self.assertRaisesRegex(ValueError, "spoon"):
            hapton.run_loop("zwidth", program=HAPTON, device="spoon")
        with self.assertRaisesRegex(ValueError, "no-such-program cannot be run"):
            hapton.run_loop("zwidth", program="no-such-program")


if __name__ == "__main__":
    unittest.main()

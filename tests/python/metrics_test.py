"""`io_node --metrics`, as Prometheus reads it."""
import pathlib
import re
import shutil
import socket
import subprocess
import unittest
import urllib.request

from live_system import LiveSystem


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class MetricsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.address = f"127.0.0.1:{free_port()}"
        cls.system = LiveSystem("--metrics", cls.address, scene="thin_wall.toml")

    @classmethod
    def tearDownClass(cls):
        cls.system.close()

    def scrape(self):
        with urllib.request.urlopen(f"http://{self.address}/metrics", timeout=60) as reply:
            return reply.read().decode()

    def test_each_scrape_is_measured_anew(self):
        def up_s():
            return float(re.search(r"^hapton_up_seconds (\S+)", self.scrape(), re.MULTILINE).group(1))

        # If io_node stands still for half a second, the previous text is served. Then the test tries again.
        for _ in range(20):
            seconds = [up_s() for _ in range(4)]
            self.assertEqual(seconds, sorted(seconds))
            if len(set(seconds)) == 4:
                return
        self.fail(f"{seconds}: each is to be later than the one before")

    def test_promtool_finds_nothing(self):
        promtool_folder = pathlib.Path(__file__).parents[2] / "build/promtool/usr/bin"
        promtool = shutil.which("promtool") or shutil.which("promtool", path=promtool_folder)
        if not promtool:
            self.skipTest("promtool is not here: deploy/promtool")
        checked = subprocess.run([promtool, "check", "metrics"], input=self.scrape(), capture_output=True, text=True)
        self.assertEqual((checked.returncode, checked.stdout + checked.stderr), (0, ""))


if __name__ == "__main__":
    unittest.main()

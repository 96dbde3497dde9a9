"""`io_node --metrics`, as Prometheus reads it."""
import re
import shutil
import socket
import subprocess
import unittest
import urllib.request

from live_system import LiveSystem


def free_port():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return taken.getsockname()[1]


class MetricsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.address = f"127.0.0.1:{free_port()}"
        cls.system = LiveSystem("--metrics", cls.address, scene="thin_wall.toml")

    @classmethod
    def tearDownClass(cls):
        cls.system.close()

    def scrape(self):
        with urllib.request.urlopen(f"http://{self.address}/metrics", timeout=20) as answer:
            return answer.read().decode()

    def test_each_scrape_is_measured_anew(self):
        seconds = [float(re.search(r"^hapton_up_seconds (\S+)", self.scrape(), re.MULTILINE).group(1)) for _ in range(4)]
        self.assertEqual(seconds, sorted(set(seconds)), "each later than the one before")

    def test_promtool_finds_nothing(self):
        if not shutil.which("promtool"):  # Debian: prometheus
            self.skipTest("promtool is not installed")
        checked = subprocess.run(["promtool", "check", "metrics"], input=self.scrape(), capture_output=True, text=True)
        self.assertEqual((checked.returncode, checked.stdout + checked.stderr), (0, ""))


if __name__ == "__main__":
    unittest.main()

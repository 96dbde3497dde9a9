"""Finds the tests that execute a mutant, and whether they detect it."""

import contextlib
import os
import re
import signal
import subprocess
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

# For each layer: its own test program first, then those of the nearest layers that use it, for mutants that its own tests do not detect.
PROGRAMS = {
    "core/base": ["core_base_test", "core_force_test"],
    "core/math": ["core_math_test", "core_geometry_test", "core_collision_test", "core_force_test"],
    "core/effects": ["core_effects_test", "haptic_step_test", "haptics_node_test"],
    "core/geometry": ["core_geometry_test", "core_collision_test", "core_force_test", "scene_test"],
    "core/sculpt": ["core_sculpt_test", "core_force_test", "vision_node_test"],
    "core/collision": ["core_collision_test", "core_force_test", "core_tool_test"],
    "core/force": ["core_force_test", "haptic_step_test", "tools_test"],
    "core/tool": ["core_tool_test", "haptic_step_test", "haptics_node_test"],
    "runtime": ["runtime_test", "io_node_test", "tools_test"],
    "plugin": ["plugin_test", "haptic_step_test", "tools_test"],
    "link": ["link_test", "devices_test", "io_node_test", "haptics_node_test", "tools_test"],
    "recording": ["recording_test", "tools_test", "vision_node_test"],
    "vrpn": ["vrpn_test", "io_node_test", "vision_node_test"],
    "hid": ["hid_test", "devices_test"],
    "scene": ["scene_test", "haptics_node_test", "tools_test"],
    "watchdog": ["watchdog_test", "io_node_test"],
    "devices": ["devices_test", "io_node_test"],
    "safety": ["safety_test", "io_node_test"],
    "haptic_step": ["haptic_step_test", "haptics_node_test", "tools_test"],
    "closed_loop": ["closed_loop_test", "tools_test"],
    "patch": ["patch_test", "io_node_test", "haptics_node_test"],
    "remote_touch": ["remote_touch_test", "tools_test"],
    "io_node": ["io_node_test", "process_test"],
    "haptics_node": ["haptics_node_test", "process_test"],
    "vision_node": ["vision_node_test", "vision_node_display_test"],
    "tools": ["tools_test", "dds_test", "process_test"],
}
# Their tests run whole programs in real time. They run one at a time.
SERIAL = ("process_test", "vision_node_display_test")
# With a mutant, tests may take TIME_FACTOR times their time without one, and EXTRA_TIME_S in addition. So an endless loop is detected too.
TIME_FACTOR = 4.0
EXTRA_TIME_S = 10.0
MAX_TEST_S = 300.0
QUICK_S = 0.3


def layer_of(path: str) -> str:
    return next((layer for layer in sorted(PROGRAMS, key=len, reverse=True) if path.startswith(layer + "/")), "")


@dataclass
class Test:
    program: str
    name: str
    passed: bool  # without a mutant
    seconds: float
    reached: set[int]  # numbers of the mutants whose place it executes


class TestRunner:
    """Runs the tests of a build. Each test first runs alone and without a mutant: only tests that execute a mutant's place can detect it."""

    def __init__(self, root: Path, count: int, jobs: int):
        self.folder = root / "build/release/tests"
        self.count = count
        self.jobs = jobs
        self.tests: list[Test] = []
        self.measured: set[str] = set()
        self.serial = threading.Lock()

    def run(self, program: str, chosen: list[str], mutant: int, timeout_s: float, reached: Path | None = None) -> tuple[int | None, str]:
        """Returns the exit code (None: the tests took too long) and the output. In the file `reached` the program marks mutants."""
        words = [str(self.folder / program), "--gtest_brief=1", f"--gtest_filter={':'.join(chosen)}"] + (["--gtest_fail_fast"] if mutant else [])
        environment = dict(os.environ, HAPTON_MUTANT=str(mutant))
        if reached is not None:
            environment["HAPTON_MUTANTS_REACHED"] = str(reached)
        with self.serial if program in SERIAL else contextlib.nullcontext():
            process = subprocess.Popen(words, cwd=self.folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
            try:
                output = process.communicate(timeout=timeout_s)[0]
                return process.returncode, output.decode(errors="replace")
            except subprocess.TimeoutExpired:
                return None, ""
            finally:
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)  # the program and the programs that it started
                process.communicate()

    def list_tests(self, program: str) -> list[str]:
        text = subprocess.run([str(self.folder / program), "--gtest_list_tests"], cwd=self.folder, check=True, stdout=subprocess.PIPE, text=True).stdout
        names, suite = [], ""
        for line in text.splitlines():
            word = line.split("#")[0].strip()
            if not line.startswith(" "):
                suite = word if word.endswith(".") else ""
            elif suite and "DISABLED_" not in suite + word:
                names.append(suite + word)
        return names

    def measure(self, programs: list[str]) -> list[Test]:
        """Runs the tests of those programs that were not measured yet. Returns the tests that fail without a mutant, which are left out."""
        unmeasured = [program for program in programs if program not in self.measured]
        with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(self.jobs) as pool:
            todo = [(program, name) for program in unmeasured for name in self.list_tests(program)]
            tests = list(pool.map(lambda numbered: self.measure_one(Path(folder) / str(numbered[0]), *numbered[1]), enumerate(todo)))
        self.measured.update(unmeasured)
        self.tests += tests
        return [test for test in tests if not test.passed]

    def measure_one(self, reached: Path, program: str, name: str) -> Test:
        reached.write_bytes(bytes(self.count + 1))
        start = time.monotonic()
        code, _ = self.run(program, [name], 0, MAX_TEST_S, reached)
        numbers = {number for number, byte in enumerate(reached.read_bytes()) if byte}
        reached.unlink()
        return Test(program, name, code == 0, time.monotonic() - start, numbers)

    def find_executing_tests(self, path: str, number: int) -> list[Test]:
        return [test for test in self.tests if test.passed and number in test.reached and test.program in PROGRAMS[layer_of(path)]]

    def find_detecting_test(self, path: str, number: int, program: str) -> str:
        """Returns the test of that program that detects the mutant; "": none does. Quick tests run first."""
        executing_tests = [test for test in self.find_executing_tests(path, number) if test.program == program]
        for are_quick in (True, False):
            chosen = [test for test in executing_tests if (test.seconds < QUICK_S) == are_quick]
            if chosen:
                detecting_test = self.find_failure(program, chosen, number)
                if detecting_test:
                    return detecting_test
        return ""

    def find_failure(self, program: str, chosen: list[Test], number: int) -> str:
        timeout_s = EXTRA_TIME_S + TIME_FACTOR * sum(test.seconds for test in chosen)
        code, text = self.run(program, [test.name for test in chosen], number, timeout_s)
        if code == 0:
            return ""
        if code is None:
            return f"{program} took too long"
        failed = sorted(set(re.findall(r"\[  FAILED  \] ([\w/]+\.[\w/]+)", text)))
        if not failed:
            return f"{program} ended with {code}"
        # A test that failed because the machine stalled passes when it runs again.
        if self.run(program, failed, number, timeout_s)[0] == 0:
            other_tests = [test for test in chosen if test.name not in failed]
            return self.find_failure(program, other_tests, number) if other_tests else ""
        return f"{program} {failed[0]}"

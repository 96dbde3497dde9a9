"""Which test programs concern a mutant, and whether they notice it."""

import os
import re
import subprocess
import time
from pathlib import Path

# Of each layer: its own tests first, then those of its nearest users.
PROGRAMS = {
    "core/base": ["core_base_test", "core_force_test"],
    "core/math": ["core_math_test", "core_geometry_test", "core_collision_test", "core_force_test"],
    "core/geometry": ["core_geometry_test", "core_collision_test", "core_force_test", "scene_test"],
    "core/collision": ["core_collision_test", "core_force_test"],
    "core/force": ["core_force_test", "haptic_step_test", "tools_test"],
    "runtime": ["runtime_test", "io_node_test", "tools_test"],
    "link": ["link_test", "io_node_test", "tools_test"],
    "hid": ["hid_test", "devices_test"],
    "scene": ["scene_test", "haptics_node_test"],
    "watchdog": ["watchdog_test"],
    "devices": ["devices_test", "io_node_test"],
    "safety": ["safety_test", "io_node_test"],
    "haptic_step": ["haptic_step_test", "haptics_node_test", "tools_test"],
    "loop": ["loop_test", "tools_test"],
    "patch": ["patch_test", "io_node_test", "haptics_node_test"],
    "remote": ["remote_test", "tools_test"],
    "io_node": ["io_node_test", "process_test"],
    "haptics_node": ["haptics_node_test", "process_test"],
    "vision_node": ["vision_node_test", "vision_node_display_test"],
    "tools": ["tools_test", "process_test"],
}
PATIENCE = 4.0  # times what the program took without a mutant: an endless loop is noticed, too
LEAST_S = 20.0


def layer_of(path: str) -> str:
    return next((layer for layer in sorted(PROGRAMS, key=len, reverse=True) if path.startswith(layer + "/")), "")


class TestRunner:
    """Runs test programs of a build; those tests that fail without a mutant are left out."""

    def __init__(self, root: Path):
        self.root = root
        self.folder = root / "build/release/tests"
        self.seconds: dict[str, float] = {}
        self.failing: dict[str, list[str]] = {}

    def run(self, program: str, chosen: str, mutant: int, at_most_s: float) -> tuple[bool, str, bool]:
        """Whether all passed, the output, and whether there was a test to run."""
        left_out = ":".join(self.failing.get(program, []))
        chosen = f"{chosen or '*'}-{left_out}" if left_out else chosen
        words = [str(self.folder / program), "--gtest_brief=1", f"--gtest_filter={chosen or '*'}"]
        words += ["--gtest_fail_fast"] if mutant else []
        if program == "vision_node_display_test" and "DISPLAY" not in os.environ:
            words = ["xvfb-run", "-a", "-s", "-screen 0 1280x1024x24"] + words
        environment = dict(os.environ, HAPTON_MUTANT=str(mutant))
        try:
            done = subprocess.run(words, cwd=self.folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=at_most_s)
        except subprocess.TimeoutExpired:
            return False, "took too long", True
        text = done.stdout.decode(errors="replace")
        return done.returncode == 0, text, re.search(r"\b0 tests from|\b0 tests ran", text) is None

    def measure(self, program: str):
        """How long it takes without a mutant, and which of its tests fail then."""
        start = time.monotonic()
        passed, text, _ = self.run(program, "", 0, 1800.0)
        self.seconds[program] = time.monotonic() - start
        if not passed:
            self.failing[program] = sorted(set(re.findall(r"\[  FAILED  \] ([\w/]+\.[\w/]+)", text)))
            if not self.failing[program]:
                raise SystemExit(f"mutate: {program} ends without a result: {text[-300:]}")

    def own_tests(self, path: str) -> str:
        """The filter of the tests that mirror a file: tests/core/math/types_test.cpp for core/math/types.h."""
        mirror = self.root / "tests" / re.sub(r"\.(cpp|h)$", "_test.cpp", path)
        if not mirror.exists():
            return ""
        suites = set(re.findall(r"^(?:TYPED_)?TEST(?:_F|_P)?\((\w+),", mirror.read_text(), re.MULTILINE))
        return ":".join(f"{suite}.*:*/{suite}.*" for suite in sorted(suites))

    def find_noticing(self, path: str, number: int) -> str:
        """The program that notices the mutant; empty: none does."""
        programs = [p for p in PROGRAMS[layer_of(path)] if (self.folder / p).exists()]
        own = self.own_tests(path)
        if own:
            passed, _, has_run = self.run(programs[0], own, number, max(LEAST_S, PATIENCE * self.seconds[programs[0]]))
            if has_run and not passed:
                return programs[0]
        for program in programs:
            if not self.run(program, "", number, max(LEAST_S, PATIENCE * self.seconds[program]))[0]:
                return program
        return ""

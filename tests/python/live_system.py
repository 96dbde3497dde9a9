"""Programs of the build beside a test, with a folder, a key and a port of their own."""
import os
import re
import signal
import subprocess
import tempfile
import time

SOURCE = os.environ["HAPTON_SOURCE_DIR"]
BIN = os.environ["HAPTON_BIN_DIR"]


class LiveSystem:
    def __init__(self, *io_arguments, scene=None):
        self.folder = tempfile.TemporaryDirectory()
        # Where the shared key of this user is: the module in this process looks there, too.
        os.environ["XDG_RUNTIME_DIR"] = self.folder.name
        self.programs = []
        self.io_log = self.path("io.log")
        self.io = self.start(self.io_log, "io_node", "--bind", "127.0.0.1:0", "--seconds", "120", *io_arguments)
        self.hub = self.wait_for(self.io_log, r"^hub on ([0-9.:]+),")
        if scene:
            self.haptics = self.start_haptics(scene)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def start(self, log, name, *arguments):
        with open(log, "w") as file:
            program = subprocess.Popen([os.path.join(BIN, name), *arguments], stdout=file, stderr=file)
        self.programs.append(program)
        return program

    def start_haptics(self, scene):
        log = self.path("haptics.log")
        program = self.start(log, "haptics_node", "--hub", self.hub, "--scene", os.path.join(SOURCE, "scenes", scene), "--seconds", "120")
        self.wait_for(log, "joined the hub")
        return program

    def restart_haptics(self, scene):
        """As after a crash."""
        self.haptics.kill()
        self.haptics.wait()
        self.haptics = self.start_haptics(scene)

    def wait_for(self, log, pattern, seconds=30):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            with open(log) as file:
                found = re.search(pattern, file.read(), re.MULTILINE)
            if found:
                return found.group(found.re.groups)
            time.sleep(0.02)
        with open(log) as file:
            raise AssertionError(f"{pattern!r} does not come:\n{file.read()}")

    def record_for(self, seconds, recording, least_bytes=200_000):
        """Lets the recording grow that long, and until it holds as much as a second of cycles and forces does: a machine may stand still."""
        time.sleep(seconds)
        end = time.monotonic() + 30
        while os.path.getsize(recording) < least_bytes and time.monotonic() < end:
            time.sleep(0.02)

    def end_io(self):
        """Ends io_node as a person does; what it printed."""
        self.io.send_signal(signal.SIGTERM)
        self.io.wait(30)
        with open(self.io_log) as file:
            return file.read()

    def close(self):
        for program in self.programs:
            if program.poll() is None:
                program.kill()
            program.wait()
        self.folder.cleanup()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

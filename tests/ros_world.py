"""A ROS master of one's own on the loopback, and programs that talk through it; all end with the world."""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from limner.ros.middleware import PACKAGES
from processes import PATIENCE_S, until

HERE = Path(__file__).parent


def need_ros():
    """Skip, with the line that installs it, where ROS is not there."""
    modules = ("rospy", "actionlib", "tf2_ros", "trajectory_msgs", "visualization_msgs", "nav_msgs", "sensor_msgs")
    found = shutil.which("rosmaster") and all(importlib.util.find_spec(name) for name in modules)
    if not found:
        pytest.skip(f"needs ROS 1: apt-get install -y --no-install-recommends {PACKAGES}; then make test")


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Probe:
    """``ros_probe.py`` in its own process: ``probe("call", service="/limner/start")``."""

    def __init__(self, process):
        self._process = process

    def __call__(self, do, **arguments):
        self._process.stdin.write(json.dumps({"do": do, **arguments}) + "\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        assert line, "the probe has ended"
        said = json.loads(line)
        assert "failed" not in said, said
        return said["answer"]


class World:
    def __init__(self, folder):
        self.folder, self.port = folder, free_port()
        kept = {name: value for name, value in os.environ.items() if not name.startswith("ROS_")}
        self.env = kept | {
            "ROS_MASTER_URI": f"http://127.0.0.1:{self.port}",
            "ROS_IP": "127.0.0.1",
            "ROS_HOME": str(folder),
            "OPENBLAS_NUM_THREADS": "1",
        }
        self.programs = {}

    def begin(self, name, command, **how):
        """Start a program under a name; what it says goes into a file of that name."""
        with open(self.folder / f"{name}.log", "ab") as log:
            how = {"stdout": log, "stderr": log} | how
            self.programs[name] = subprocess.Popen(command, env=self.env, start_new_session=True, **how)
        return self.programs[name]

    def limner(self, name, *arguments):
        return self.begin(name, [sys.executable, "-m", "limner", "ros", name, *arguments])

    def master(self):
        self.begin("master", ["rosmaster", "--core", "-p", str(self.port)])
        until(self.answers)

    def answers(self):
        with socket.socket() as s:
            return s.connect_ex(("127.0.0.1", self.port)) == 0

    def probe(self):
        how = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        return Probe(self.begin("probe", [sys.executable, str(HERE / "ros_probe.py")], **how))

    def end(self, name, how=signal.SIGTERM):
        """End a program and wait for it."""
        program = self.programs.pop(name)
        program.send_signal(how)
        try:
            program.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            program.kill()
            program.wait()
        for pipe in filter(None, (program.stdin, program.stdout)):
            # What a program that died was told last cannot be flushed, and must not keep the others from their end.
            with contextlib.suppress(BrokenPipeError):
                pipe.close()

    def said(self, name):
        return (self.folder / f"{name}.log").read_text(errors="replace")

    def close(self):
        for name in reversed(list(self.programs)):
            self.end(name)

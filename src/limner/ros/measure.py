"""A photo goes in; how soon the node plans it, how evenly joints are reported and how memory grows come out."""

from __future__ import annotations

import functools
import os
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from limner.errors import DeviceFailed
from limner.ros import messages
from limner.ros.begin import begin, end
from limner.ros.links import RATE_HZ
from limner.ros.middleware import ros
from limner.types import Photo

PATIENCE_S = 120.0


@dataclass(frozen=True)
class RosFigures:
    """What was measured on a master, a node and a controller of their own, on the loopback.

    Attributes:
        photo_to_trajectory_s: median time from a photo's message to its trajectory's.
        photo_to_trajectory_cpu_s: median CPU time of the node for it.
        joint_states_hz: how often joints are reported, by median distance.
        jitter_ms: median difference of the distance between two reports from what it should be.
        jitter_p95_ms: 95 % are within.
        portraits: drawn one after the other.
        memory_mb: of the node after the second of them.
        growth_mb: of its memory from there to the last.
    """

    photo_to_trajectory_s: float
    photo_to_trajectory_cpu_s: float
    joint_states_hz: float
    jitter_ms: float
    jitter_p95_ms: float
    portraits: int
    memory_mb: float
    growth_mb: float


def measure(photo: Photo, portraits: int, told: Callable[[int], None] = lambda done: None) -> RosFigures:
    """Start master, controller and node, have portraits drawn, end all.

    Args:
        photo: published again and again, mirrored every other time.
        portraits: how often, at least 2.
        told: how many are done.

    Raises:
        DeviceFailed: nothing came of a photo.
        MissingRos: ROS is not there.
    """
    r = ros()
    with _world() as node:
        begin("limner_measure", [])
        try:
            planned = threading.Event()
            stamps: list[float] = []
            r.rospy.Subscriber("trajectory", r.trajectory.JointTrajectory, lambda _: planned.set())
            r.rospy.Subscriber("joint_states", r.sensor.JointState, lambda m: stamps.append(m.header.stamp.to_sec()))
            publisher = r.rospy.Publisher("image", r.sensor.Image, queue_size=1)
            _wait(lambda: publisher.get_num_connections() > 0 and len(stamps) > 0, "node and controller")
            time.sleep(_WARM_S)
            seconds, cpu, memory = [], [], []
            for number in range(portraits):
                shown = Photo(photo.rgb[:, ::-1]) if number % 2 else photo
                message, used = messages.fill_image(r.sensor.Image(), shown), _cpu_s(node)
                seconds.append(_until(planned, functools.partial(publisher.publish, message)))
                cpu.append(_cpu_s(node) - used)
                memory.append(_memory_mb(node))
                told(number + 1)
        finally:
            end()
    return _figures(seconds, cpu, memory, stamps)


def _until(planned: threading.Event, begin_work: Callable[[], None]) -> float:
    """Seconds from the beginning of some work until a trajectory comes of it."""
    planned.clear()
    began = time.perf_counter()
    begin_work()
    if not planned.wait(PATIENCE_S):
        raise DeviceFailed("limner ros node: no trajectory came of a photo; does it show a face?")
    return time.perf_counter() - began


_WARM_S = 5.0


def _figures(seconds: list[float], cpu: list[float], memory: list[float], stamps: list[float]) -> RosFigures:
    apart = np.diff(np.array(stamps))
    jitter = 1000 * np.abs(apart - 1 / RATE_HZ)
    settled = memory[1]
    return RosFigures(
        float(np.median(seconds)),
        float(np.median(cpu)),
        float(1 / np.median(apart)),
        float(np.median(jitter)),
        float(np.percentile(jitter, 95)),
        len(seconds),
        settled,
        memory[-1] - settled,
    )


@contextmanager
def _world() -> Iterator[int]:
    """A master, a controller and a node on a free port; the node's process id. This process talks to that master."""
    with tempfile.TemporaryDirectory() as folder, socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
        probe.close()
        os.environ |= {"ROS_MASTER_URI": f"http://127.0.0.1:{port}", "ROS_IP": "127.0.0.1", "ROS_HOME": folder}
        limner = [sys.executable, "-m", "limner", "ros"]
        programs = [_start(["rosmaster", "--core", "-p", str(port)])]
        try:
            _wait(ros().rosgraph.is_master_online, "the master")
            programs += [_start([*limner, "controller"]), _start([*limner, "node"])]
            yield programs[-1].pid
        finally:
            for program in reversed(programs):
                program.terminate()
                program.wait()


def _start(command: list[str]) -> subprocess.Popen[bytes]:
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def _wait(happened: Callable[[], Any], what: str) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not happened():
        if time.monotonic() > deadline:
            raise DeviceFailed(f"{what}: no answer in {PATIENCE_S:.0f} s")
        time.sleep(0.1)


def _cpu_s(process: int) -> float:
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _memory_mb(process: int) -> float:
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20

"""``limner ros demo``: a photo or drawing in; a master, a simulated arm, the node and rviz run until one ends."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any
from urllib.parse import urlparse
from xml.etree import ElementTree

from limner.errors import BadInput, DeviceFailed
from limner.motion.arm import robots
from limner.motion.arm.robot import Robot
from limner.motion.arm.robots import ROBOTS, load_robot
from limner.motion.arm.urdf import MOVING
from limner.ros.begin import begin, end, end_on_sigterm
from limner.ros.middleware import MissingRos, ros
from limner.targets.files import READABLE

READY_S = 180.0
"""How long the node may take until it has a plan."""

_LOOK_S = 0.1
_GRACE_S = 10.0
_STATE_PUBLISHER = "robot_state_publisher"


@dataclass(frozen=True)
class Show:
    """What is shown.

    Attributes:
        source: a photo, or a drawing.
        robot: name of the arm, or its URDF.
        rviz: whether rviz is started.
        once: whether all ends when the drawing is drawn.
        speed: how much faster than real the simulated arm's time goes.
        arguments: for the node, as ROS takes them.
    """

    source: str
    robot: str = "dumbo"
    rviz: bool = True
    once: bool = False
    speed: float = 1.0
    arguments: tuple[str, ...] = ()


def run(show: Show, told: Callable[[str], None]) -> None:
    """Start all that is missing, have it drawn, and end all that was started.

    Args:
        show: what.
        told: what the node says.

    Raises:
        LimnerError: ROS or a program of it is not there, or one of them ended by itself.
    """
    r = ros()
    robot, urdf = load_robot(show.robot), _urdf(show.robot)
    programs = _programs(show, robot, urdf)
    end_on_sigterm()
    with _running() as running:
        if not r.rosgraph.is_master_online():
            port = urlparse(r.rosgraph.get_master_uri()).port or 11311
            running["the master"] = _start(["rosmaster", "--core", "-p", str(port)])
            _until(r.rosgraph.is_master_online, running, "the master does not answer")
        r.rosgraph.Master("/limner_demo").setParam("/robot_description", urdf)
        for name, command in programs.items():
            running[name] = _start(command)
        begin("limner_demo", [])
        try:
            _draw(show, running, told)
        except KeyboardInterrupt:
            told("ending")
        finally:
            end()


def _draw(show: Show, running: dict[str, subprocess.Popen[bytes]], told: Callable[[str], None]) -> None:
    r = ros()
    said: list[str] = []

    def hear(message: Any) -> None:
        said.append(message.data)
        told(message.data)

    r.rospy.Subscriber("status", r.std.String, hear)
    _until(lambda: any(text.startswith(("planned", "refused")) for text in said), running, "the node has no plan")
    if refused := next((text for text in said if text.startswith("refused")), ""):
        raise BadInput(refused.removeprefix("refused: "))
    answer = r.rospy.ServiceProxy("limner/start", r.srvs.Trigger)()
    if not answer.success:
        raise DeviceFailed(answer.message)
    while not (show.once and said[-1].startswith("drawn: ") and "of" in said[-1]):
        _check(running)
        time.sleep(_LOOK_S)


def _programs(show: Show, robot: Robot, urdf: str) -> dict[str, list[str]]:
    """Command of each program, by what it is called in messages."""
    limner = [sys.executable, "-m", "limner", "ros"]
    kind = "drawing" if Path(show.source).suffix.lower() in READABLE else "photo"
    # rospy takes what looks like a number for one.
    source = f"_{kind}:={Path(show.source).resolve()}"
    still = [name for name in _moving(urdf) if name not in robot.joints]
    arm = [f"_robot:={show.robot}", f"_speed:={show.speed}", f"_also:=[{', '.join(still)}]"]
    programs = {
        _STATE_PUBLISHER: [_find(_STATE_PUBLISHER)],
        "the controller": [*limner, "controller", *arm],
        "the node": [*limner, "node", f"_robot:={show.robot}", source, "_tf:=paper", *show.arguments],
    }
    if show.rviz:
        config = str(resources.files(__package__) / "limner.rviz")
        programs["rviz"] = [_find("rviz"), "-d", config, "-f", "base_link" if "base_link" in urdf else robot.base]
    return programs


def _find(program: str) -> str:
    folders = os.pathsep.join([os.environ.get("PATH", ""), f"/usr/lib/{program}", f"/opt/ros/noetic/lib/{program}"])
    if found := shutil.which(program, path=folders):
        return found
    raise MissingRos(program)


def _urdf(robot: str) -> str:
    if robot in ROBOTS:
        return (resources.files(robots) / f"{robot}.urdf").read_text()
    return Path(robot).read_text()


def _moving(urdf: str) -> list[str]:
    """Names of the joints that move; the file was read, and found safe, as a robot before."""
    joints = ElementTree.fromstring(urdf).iter("joint")
    return [joint.get("name", "") for joint in joints if joint.get("type") in MOVING]


@contextlib.contextmanager
def _running() -> Iterator[dict[str, subprocess.Popen[bytes]]]:
    """Programs that are ended in the end, the last one first."""
    running: dict[str, subprocess.Popen[bytes]] = {}
    try:
        yield running
    finally:
        for program in reversed(running.values()):
            _end(program)


def _start(command: list[str]) -> subprocess.Popen[bytes]:
    # In a session of its own: Ctrl-C in the terminal is ours, and all end in order.
    quiet = subprocess.DEVNULL
    return subprocess.Popen(command, stdin=quiet, stdout=quiet, start_new_session=True)


def _end(program: subprocess.Popen[bytes]) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(program.pid, signal.SIGTERM)
    try:
        program.wait(_GRACE_S)
    except subprocess.TimeoutExpired:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(program.pid, signal.SIGKILL)
        program.wait()


def _until(happened: Callable[[], bool], running: dict[str, subprocess.Popen[bytes]], otherwise: str) -> None:
    deadline = time.monotonic() + READY_S
    while not happened():
        _check(running)
        if time.monotonic() > deadline:
            raise DeviceFailed(f"{otherwise} after {READY_S:.0f} s")
        time.sleep(_LOOK_S)


def _check(running: dict[str, subprocess.Popen[bytes]]) -> None:
    for name, program in running.items():
        if program.poll() is not None:
            raise DeviceFailed(f"{name} has ended (code {program.returncode}); so does the demonstration")

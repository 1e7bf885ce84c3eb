"""``limner ros``: without ROS, without a master, and the whole demonstration with rviz in a network of its own."""

from __future__ import annotations

import os
import shutil
import signal
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from processes import PATIENCE_S, until
from ros_world import free_port, need_ros

SCREEN = (1280, 800)
STAGE = """
ip link set lo up
Xvfb :{display} -screen 0 1280x800x24 -nolisten tcp -fbdir {folder} &
screen=$!
trap 'kill $demo' TERM
DISPLAY=:{display} {python} -m limner ros demo {photo} --speed 5 _points:=80 2>{folder}/said &
demo=$!
wait $demo; wait $demo
echo $? >{folder}/code
kill $screen
wait
"""


def limner(*arguments, code="", **env):
    program = f"import sys; {code}\nfrom limner.cli import main\nsys.argv = ['limner', *{list(arguments)!r}]\nmain()"
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=os.environ | env)


@pytest.mark.parametrize("command", ["node", "controller"])
def test_without_ros_it_says_what_to_install_and_how_it_is_found(command):
    done = limner("ros", command, code="sys.modules['rospy'] = None")
    assert done.returncode == 2
    first, second = done.stderr.splitlines()
    assert "apt-get install" in first
    assert "python3-rospy" in first
    assert "/usr/lib/python3/dist-packages" in second
    assert "zz_debian_ros.pth" in second


@pytest.mark.parametrize("command", ["node", "controller"])
def test_without_a_master_it_says_how_to_start_one(command, tmp_path):
    need_ros()
    where = {"ROS_MASTER_URI": f"http://127.0.0.1:{free_port()}", "ROS_IP": "127.0.0.1", "ROS_HOME": str(tmp_path)}
    done = limner("ros", command, **where)
    assert done.returncode == 5
    assert "no ROS master at" in done.stderr.splitlines()[-1]


def screenshot(file):
    """The picture (H, W, 3) in a frame buffer of Xvfb (the format of xwd)."""
    data = file.read_bytes()
    head = struct.unpack(">25I", data[:100])
    size, width, height, row, colours = head[0], head[4], head[5], head[12], head[19]
    pixels = np.frombuffer(data, np.uint8, offset=size + 12 * colours, count=row * height)
    return pixels.reshape(height, row)[:, : 4 * width].reshape(height, width, 4)[..., 2::-1]


def drawn_in(said):
    """Whether a plan has been drawn."""
    return said.exists() and "drawn: " in said.read_text().partition("planned")[2]


def left_over(mark):
    """Processes that have a word in their environment."""
    found = []
    for place in Path("/proc").glob("[0-9]*/environ"):
        try:
            if mark.encode() in place.read_bytes():
                found.append(place.parent.name)
        except OSError:
            continue
    return found


@pytest.mark.slow
def test_the_demonstration_shows_the_arm_and_its_ink_in_rviz_and_ends_all_it_began(tmp_path):
    need_ros()
    skimage = pytest.importorskip("skimage")
    if missing := [name for name in ("rviz", "Xvfb", "unshare", "ip") if not shutil.which(name, path=SEARCHED)]:
        pytest.skip(f"needs {missing[0]}: apt-get install -y --no-install-recommends rviz xvfb iproute2 util-linux")
    photo = Path(skimage.__file__).parent / "data" / "astronaut.png"
    port = free_port()
    stage = STAGE.format(display=100 + port % 800, folder=tmp_path, python=sys.executable, photo=photo)
    env = os.environ | {
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_IP": "127.0.0.1",
        "ROS_HOME": str(tmp_path),
        "LIBGL_ALWAYS_SOFTWARE": "1",
        "QT_X11_NO_MITSHM": "1",
        "XDG_RUNTIME_DIR": str(tmp_path),
        "PATH": SEARCHED,
    }
    said = tmp_path / "said"
    with open(tmp_path / "stage", "wb") as log:
        # roscpp programs listen to everybody: here nobody else is there.
        program = subprocess.Popen(["unshare", "-rn", "sh", "-c", stage], env=env, stdout=log, stderr=log)
    try:
        until(lambda: program.poll() is not None or drawn_in(said), lambda: said.read_text() if said.exists() else "")
        assert program.poll() is None, said.read_text()
        until(lambda: ink_on_white(screenshot(tmp_path / "Xvfb_screen0")) > 300)
        picture = screenshot(tmp_path / "Xvfb_screen0")
    finally:
        program.send_signal(signal.SIGTERM)
        program.wait(PATIENCE_S)
    assert picture.shape == (SCREEN[1], SCREEN[0], 3)
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 500
    assert (tmp_path / "code").read_text().strip() == "0"
    assert "ending" in said.read_text()
    until(lambda: not left_over(f":{port}\0"))


def ink_on_white(picture):
    """Dark pixels amid the sheet, which is the one thing that is nearly white in the view."""
    view = picture[70:, 370:1260].astype(int)
    sheet = (view > 240).all(-1)
    rows, columns = np.flatnonzero(sheet.sum(1) > 20), np.flatnonzero(sheet.sum(0) > 20)
    if not len(rows) or not len(columns):
        return 0
    amid = view[rows[0] : rows[-1], columns[0] : columns[-1]]
    return int((amid < 90).all(-1).sum())


SEARCHED = os.environ.get("PATH", "") + ":/usr/sbin:/sbin"

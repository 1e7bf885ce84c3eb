"""A studio for tests: started as a stranger starts it, entered as a browser enters it, and ended whatever happens."""

from __future__ import annotations

import contextlib
import io
import itertools
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import httpx
import numpy as np
import uvicorn
from PIL import Image
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from limner.cli.evaluate import astronaut

PATIENCE_S = 240.0
"""A busy machine is no failure."""

_PORTS = itertools.count(12_000 + os.getpid() * 101 % 18_000)
"""Of this process alone: a port that is let go of for a moment is not taken by the server of another test."""


class Server:
    """``limner studio`` in a process of its own.

    Attributes:
        url: with the token.
        base: without.
        state: the folder of what outlasts it.
    """

    def __init__(self, *arguments, cwd=None, state=None, own_port=True):
        self._passing = tempfile.TemporaryDirectory() if state is None else None
        self.state = Path(state or self._passing.name)
        environment = os.environ | {"XDG_STATE_HOME": str(self.state)}
        port = ("--port", free_port()) if own_port and "--port" not in arguments else ()
        command = [sys.executable, "-m", "limner", "studio", "--no-browser", "--json", *map(str, (*arguments, *port))]
        self._process = subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=cwd,
            start_new_session=True,
            env=environment,
        )
        killer = threading.Timer(PATIENCE_S, self._process.kill)
        killer.start()
        line = self._process.stdout.readline()
        killer.cancel()
        assert line, self._process.stderr.read()
        self.said = json.loads(line)
        self.url = self.said["url"]
        self.base = self.url.partition("/?")[0]

    @property
    def pid(self):
        return self._process.pid

    @property
    def port(self):
        return self.base.rpartition(":")[2]

    def hurry(self, to):
        """What is left of a job is drawn at another pace: of one that is slow any part can be waited for."""
        hurry(self.state, to)

    def kill(self):
        """As a power cut does."""
        self._process.send_signal(signal.SIGKILL)
        self._process.wait(PATIENCE_S)
        self.close()

    def close(self):
        """End it as Ctrl-C does; its exit code and what it said to the terminal."""
        if self._process.stderr.closed:
            return self._process.returncode, ""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
        try:
            _, err = self._process.communicate(timeout=PATIENCE_S)
        except subprocess.TimeoutExpired:
            os.killpg(self._process.pid, signal.SIGKILL)
            _, err = self._process.communicate()
        self._process.stdout.close()
        self._process.stderr.close()
        if self._passing is not None:
            self._passing.cleanup()
        return self._process.returncode, err


def free_port():
    """One that nobody listens on."""
    while True:
        with contextlib.suppress(OSError), socket.create_server(("127.0.0.1", next(_PORTS))) as listening:
            return listening.getsockname()[1]


def hurry(state, to):
    """As ``Server.hurry``, in the folder of what outlasts a server."""
    (order,) = Path(state).rglob("order.json")
    order.write_text(json.dumps(json.loads(order.read_text()) | {"to": to}))


@contextlib.contextmanager
def serving(*arguments, cwd=None, state=None, own_port=True):
    server = Server(*arguments, cwd=cwd, state=state, own_port=own_port)
    try:
        yield server
    finally:
        server.close()


@contextlib.contextmanager
def thread_serving(build):
    """An application in a thread of this process; ``build`` makes it for a port."""
    listening = socket.create_server(("127.0.0.1", 0))
    port = listening.getsockname()[1]
    config = uvicorn.Config(build(port), log_level="error", ws="websockets-sansio", timeout_graceful_shutdown=1)
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]}, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{port}"
    finally:
        server.should_exit = True
        thread.join(PATIENCE_S)
        listening.close()


@contextlib.contextmanager
def enter(server, url=None):
    """A browser that has visited the printed address."""
    with httpx.Client(base_url=server.base, follow_redirects=True, timeout=PATIENCE_S) as client:
        client.headers["origin"] = server.base
        client.get(url or server.url, headers={"sec-fetch-site": "none"})
        yield client


@contextlib.contextmanager
def live(client, origin=None, path="/ws"):
    """Its live socket."""
    base = str(client.base_url).rstrip("/")
    cookie = "; ".join(f"{name}={value}" for name, value in client.cookies.items())
    headers = {"Cookie": cookie} if cookie else {}
    with connect(
        base.replace("http", "ws") + path, additional_headers=headers, origin=origin or base, open_timeout=PATIENCE_S
    ) as socket:
        yield Talk(socket)


def refused(client, base, path):
    """Whether a socket is not opened."""
    try:
        with live(client, base, path):
            return False
    except InvalidStatus:
        return True


class Talk:
    """Messages in, messages out, frames with them."""

    def __init__(self, socket):
        self.socket = socket

    def wish(self, **wish):
        self.socket.send(json.dumps(wish))

    def hear(self, until=lambda message: message["type"] not in ("job", "queue"), patience_s=PATIENCE_S):
        """The first message that is the right one, with its frame."""
        ends = time.monotonic() + patience_s
        while True:
            message = json.loads(self.socket.recv(timeout=max(0.01, ends - time.monotonic())))
            frame = self.socket.recv(timeout=PATIENCE_S) if message.get("frame") else None
            if until(message):
                return message, frame


def face_jpeg(side=400):
    """The head of the astronaut, as JPEG."""
    out = io.BytesIO()
    Image.open(astronaut()).crop((80, 0, 380, 300)).resize((side, side)).save(out, "JPEG", quality=92)
    return out.getvalue()


def picture(kind="PNG", size=(64, 64), **more):
    """A picture with no face in it."""
    out = io.BytesIO()
    Image.fromarray(np.full((size[1], size[0], 3), 200, np.uint8)).save(out, kind, **more)
    return out.getvalue()


def moving(kind="GIF"):
    """A picture that moves."""
    frames = [Image.new("RGB", (40, 40), colour) for colour in ("red", "green", "blue")]
    out = io.BytesIO()
    frames[0].save(out, kind, save_all=True, append_images=frames[1:], duration=50)
    return out.getvalue()

"""Programs that a test begins end with it, whatever happens; what must come is waited for, long, but not for ever."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
import time

PATIENCE_S = 240
"""How long anything may take: a busy machine is no failure, a program that hangs is one."""


def until(what, told="it never happened", patience_s=PATIENCE_S, look_s=0.02):
    """The first true answer; past all patience a failure that says what was waited for."""
    deadline = time.monotonic() + patience_s
    while not (answer := what()):
        assert time.monotonic() < deadline, told() if callable(told) else told
        time.sleep(look_s)
    return answer


@contextlib.contextmanager
def begun(command, patience_s=PATIENCE_S, **how):
    """``subprocess.Popen`` that is killed, with all of its session if it has one of its own, when it is not over yet.

    It is past all patience too, so that whoever reads what it says comes to an end.
    """
    process = subprocess.Popen(command, **how)

    def kill():
        # Whatever belongs to its session goes with it.
        with contextlib.suppress(ProcessLookupError):
            if how.get("start_new_session"):
                os.killpg(process.pid, signal.SIGKILL)
            else:
                process.kill()

    alarm = threading.Timer(patience_s, kill)
    alarm.daemon = True
    alarm.start()
    try:
        with process:
            try:
                yield process
            finally:
                if process.poll() is None:
                    kill()
    finally:
        alarm.cancel()

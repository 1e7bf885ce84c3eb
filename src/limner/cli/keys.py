"""Keys and signals go in while a machine draws; what the user wants with it comes out in a ``Control``."""

from __future__ import annotations

import contextlib
import select
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from types import FrameType

from limner.targets.send import Control

LOOK_S = 0.1


@contextlib.contextmanager
def interrupts(control: Control, tell: Callable[[str], None]) -> Iterator[None]:
    """Ctrl-C, SIGTERM and a closed terminal ask to stop with the pen up; a second one stops at once."""

    def handle(number: int, frame: FrameType | None) -> None:
        if control.stop:
            raise KeyboardInterrupt
        control.stop = True
        with contextlib.suppress(OSError):  # the terminal may be the one that was closed
            tell("stopping; Ctrl-C again: at once")

    asked = [signal.SIGINT, signal.SIGTERM]
    hang_up = getattr(signal, "SIGHUP", None)
    # Who started it with nohup wants it to go on.
    if hang_up is not None and signal.getsignal(hang_up) is not signal.SIG_IGN:
        asked.append(hang_up)
    before = {which: signal.signal(which, handle) for which in asked}
    try:
        yield
    finally:
        for which, handler in before.items():
            signal.signal(which, handler)


@contextlib.contextmanager
def pause_key(control: Control, tell: Callable[[str], None]) -> Iterator[None]:
    """Space pauses with the pen up and goes on, if a terminal is there to press it on."""
    if not sys.stdin.isatty():
        yield
        return
    try:
        import termios
        import tty
    except ImportError:  # another system's terminal
        yield
        return
    file = sys.stdin.fileno()
    before = termios.tcgetattr(file)
    ended = threading.Event()
    thread = threading.Thread(target=_watch, args=(control, tell, ended), daemon=True)
    tty.setcbreak(file)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
        termios.tcsetattr(file, termios.TCSADRAIN, before)


def _watch(control: Control, tell: Callable[[str], None], ended: threading.Event) -> None:
    while not ended.is_set():
        if select.select([sys.stdin], [], [], LOOK_S)[0] and sys.stdin.read(1) == " ":
            control.pause = not control.pause
            tell("pausing" if control.pause else "going on")

"""Fake plotters wired up for tests: in memory, and behind a pseudo-terminal as a real port would be."""

from __future__ import annotations

import contextlib
import os
import select
import threading
import time
from collections import Counter

import numpy as np

from limner import geometry
from limner.motion.machine import load_machine
from limner.motion.pen import plan
from limner.targets.ebb import Ebb, EbbSettings, Limits
from limner.targets.fake import FakeLink
from limner.targets.fake_ebb import FakeEbb
from limner.targets.fake_grbl import FakeGrbl
from limner.targets.gcode import GcodeSettings
from limner.targets.grbl import Grbl
from limner.types import Drawing, Page, Pen

SILENCE_S = 0.05
"""What tests wait for a machine that says nothing."""


def grbl(pen="servo", silence_s=SILENCE_S, **kind):
    """A fake GRBL plotter and its driver."""
    settings = GcodeSettings(pen=pen)
    fake = FakeGrbl(pen=pen, down_word=settings.servo_down if pen == "servo" else settings.z_down_mm, **kind)
    return fake, Grbl(FakeLink(fake), settings, (0.0, 0.0), silence_s)


def ebb(silence_s=SILENCE_S, page=None, **kind):
    """A fake AxiDraw and its driver."""
    machine, page = load_machine("axidraw"), page or Page()

    def motion(start, line):
        return plan(Drawing((line,), ("face",), [1.0], page, (Pen(),)), machine, start, None)

    home = tuple(machine.home_mm(page).tolist())
    limits = Limits(machine.travel_mm_s, machine.draw_mm_s**2 / (2 * machine.draw_mm_s2))
    fake = FakeEbb(home=home, **kind)
    return fake, Ebb(FakeLink(fake), motion, EbbSettings(), home, limits, silence_s)


def counted(lines):
    """How often the pen goes over each segment, and each dot, to a thousandth of a millimetre, as it is written."""
    found = Counter()
    for line in lines:
        # As a decimal is written, not as numpy rounds: 0.0005 is told as 0.001, which is a way to go.
        written = [[float(f"{value:.3f}") for value in point] for point in np.asarray(line, float)]
        line = geometry.without_repeats(np.array(written).reshape(-1, 2))
        pairs = list(zip(line[:-1].tolist(), line[1:].tolist(), strict=True)) or [(line[0].tolist(), line[0].tolist())]
        found.update(tuple(sorted((tuple(a), tuple(b)))) for a, b in pairs)
    return found


def inked(fake):
    """The same of what a fake has drawn."""
    return counted([np.array(segment) for segment in fake.ink])


class Served:
    """A fake behind a pseudo-terminal, in a thread; ``port`` is what a program opens.

    Args:
        fake: to serve.
        step_s: how long it takes for each thing it does; may be changed while it runs.
    """

    def __init__(self, fake, step_s=0.0):
        self.fake, self.step_s = fake, step_s
        self._master, self._slave = os.openpty()
        os.set_blocking(self._master, False)
        self.port = os.ttyname(self._slave)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._ended.set()
        self._thread.join()
        self._unplug()

    def _unplug(self):
        for file in (self._master, self._slave):
            with contextlib.suppress(OSError):
                os.close(file)
        self._master = self._slave = -1

    def _serve(self):
        while not self._ended.is_set():
            if self.fake.gone:
                return self._unplug()
            if select.select([self._master], [], [], 0)[0]:
                with contextlib.suppress(OSError):
                    self.fake.receive(os.read(self._master, 4096))
            busy = self.fake.step()
            if said := self.fake.take():
                os.write(self._master, said)
            time.sleep(self.step_s if busy else 0.001)
        return None


def settled(fake):
    """The fake once it has done all that it was told: a machine goes on with what is in its buffer."""
    while fake.step():
        pass
    return fake

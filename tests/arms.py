"""A small drawing, planned for Dumbo's left arm; used by tests of what is sent to ROS."""

from __future__ import annotations

import functools
import time

import numpy as np

from limner.motion.arm.legs import legs
from limner.motion.arm.plan import ArmSettings, plan_arm
from limner.motion.arm.retime import RetimeSettings
from limner.motion.arm.robots import load_robot
from limner.types import Drawing, Page

LINES = ([[10, 10], [20, 15], [25, 10]], [[10, 20]], [[10, 25], [18, 30]], [[30, 10], [25, 20], [30, 26]])
DRAWN = 4
"""Strokes of them; the dot is one of them."""
LONGEST_S = 0.06
"""A driver waits for a message for no longer before it looks at its clock again."""


def arm_clock(pace):
    """A clock of an arm that is so many times faster than real: what this process sleeps through is not counted."""
    before, passed = time.monotonic(), 0.0

    def clock():
        nonlocal before, passed
        now = time.monotonic()
        passed, before = passed + min(now - before, LONGEST_S), now
        return pace * passed

    return clock


def drawing():
    return Drawing(tuple(np.array(line, float) for line in LINES), ("face",) * 4, np.ones(4), Page(40, 40, 5))


@functools.cache
def robot():
    return load_robot("dumbo")


@functools.cache
def planned():
    return plan_arm(drawing(), robot(), ArmSettings())


@functools.cache
def route():
    return legs(planned().trajectory, robot(), RetimeSettings())

"""A model in MJCF and commands go in; where the arm, its pen and the force on the paper were comes out (MuJoCo)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from limner.errors import CannotDraw, MissingExtra
from limner.simulation.model import STEP_S, TIP_RADIUS_M
from limner.simulation.settings import SimulationSettings
from limner.types import Floats, Value

RECORD_STEPS = 2
"""Steps between two records: at 100 mm/s the pen goes 0.2 mm."""

_CREEP = 0.005
"""m/s; slower than this friction grows with speed."""

Watch = Callable[[str, int, int, str], None]


@dataclass(frozen=True, eq=False)
class Record(Value):
    """What happened.

    Attributes:
        t_s: (n,).
        q: (n, dof) positions of the joints.
        tip_m: (n, 3) where the pen touches or would touch, base frame.
        force_n: (n,) of the pen on the paper, 0 where it does not touch.
    """

    t_s: Floats
    q: Floats
    tip_m: Floats
    force_n: Floats


def step_times(until_s: float) -> Floats:
    """Times (steps,) of all steps, some rest at the end."""
    times: Floats = np.arange(0, until_s + 0.1, STEP_S)
    return times


def run(
    mjcf: str, start: Floats, told: tuple[Floats, Floats], settings: SimulationSettings, watch: Watch | None = None
) -> Record:
    """Simulate.

    Args:
        mjcf: the model.
        start: (dof,) joint positions at the beginning.
        told: positions and velocities (steps, dof) that the servos are told at each step.
        settings: gains of the servos, friction of the paper.
        watch: told of the progress.

    Raises:
        CannotDraw: the simulation became unstable.
        MissingExtra: mujoco is not installed.
    """
    try:
        import mujoco
    except ImportError as error:
        raise MissingExtra("simulating an arm", "robot") from error
    world = _World(mujoco, mjcf, start, told[0], settings)
    control = np.concatenate(told, axis=1)
    kept = np.zeros((len(control) // RECORD_STEPS, len(start) + 4))
    for k in range(len(kept)):
        for step in range(k * RECORD_STEPS, (k + 1) * RECORD_STEPS):
            world.step(control[step])
        kept[k] = *world.data.qpos[: len(start)], *world.tip_m, world.force_n
        if watch is not None and k % 500 == 0:
            watch("simulate", k, len(kept), "")
    if not np.isfinite(kept).all() or world.data.warning.number.any():
        raise CannotDraw("simulate: the arm became unstable; lower simulation.velocity_hz")
    times: Floats = STEP_S * RECORD_STEPS * np.arange(1.0, len(kept) + 1)
    return Record(times, kept[:, :-4], kept[:, -4:-1], kept[:, -1])


class _World:
    """One simulated arm, its pen and its paper."""

    def __init__(self, mujoco: Any, mjcf: str, start: Floats, told: Floats, settings: SimulationSettings) -> None:
        self.mujoco, self.friction, self.force_n = mujoco, settings.friction, 0.0
        self.model = mujoco.MjModel.from_xml_string(mjcf)
        self.data = mujoco.MjData(self.model)
        _tune(mujoco, self.model, self.data, told, settings)
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[: len(start)] = start
        mujoco.mj_forward(self.model, self.data)
        self.pen, self.tip = self.model.body("pen").id, self.model.geom("tip").id
        self.normal = self.data.geom("paper").xmat.reshape(3, 3)[:, 2].copy()
        self.tip_m = self._lowest()

    def step(self, control: Floats) -> None:
        """One step: servos, friction of the last known contact, physics."""
        self.data.ctrl[:] = control
        self.mujoco.mj_step(self.model, self.data)
        before, self.tip_m = self.tip_m, self._lowest()
        self.force_n = self._force()
        self.data.xfrc_applied[self.pen, :3] = self._friction((self.tip_m - before) / STEP_S)

    def _lowest(self) -> Floats:
        """The point of the tip's ball that is nearest to the paper."""
        place: Floats = self.data.geom_xpos[self.tip] - TIP_RADIUS_M * self.normal
        return place

    def _force(self) -> float:
        """Normal force of the pen on the paper [N]."""
        wrench, total = np.zeros(6), 0.0
        for contact in range(self.data.ncon):
            self.mujoco.mj_contactForce(self.model, self.data, contact, wrench)
            total += float(wrench[0])
        return total

    def _friction(self, velocity: Floats) -> Floats:
        """Coulomb friction, going over smoothly at rest."""
        along = velocity - (velocity @ self.normal) * self.normal
        force: Floats = -self.friction * self.force_n / max(float(np.linalg.norm(along)), _CREEP) * along
        return force


def _tune(mujoco: Any, model: Any, data: Any, told: Floats, settings: SimulationSettings) -> None:
    """Gains of the servos: a loop of velocity within one of position, for the largest inertia each joint moves."""
    dof, inertia = told.shape[1], np.zeros(told.shape[1])
    column = np.zeros(model.nv)
    for q in told[:: max(1, len(told) // 20)]:
        data.qpos[:dof] = q
        mujoco.mj_forward(model, data)
        for i, unit in enumerate(np.eye(dof, model.nv)):
            mujoco.mj_mulM(model, data, column, unit)
            inertia[i] = max(inertia[i], column[i])
    for i in range(dof):
        damping = inertia[i] * 2 * np.pi * settings.velocity_hz
        stiffness = damping * settings.position_gain
        model.actuator_gainprm[i, 0], model.actuator_biasprm[i, 1] = stiffness, -stiffness
        model.actuator_gainprm[dof + i, 0], model.actuator_biasprm[dof + i, 2] = damping, -damping

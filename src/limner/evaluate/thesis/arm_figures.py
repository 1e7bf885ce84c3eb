"""A portrait and an arm go in; the thesis's figures 4.2 to 4.5 and its drawing times, with ours, come out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.drawing.compose import compose
from limner.drawing.order import order
from limner.errors import CannotDraw
from limner.evaluate.tables import Grid
from limner.motion.arm.plan import ArmPlan, plan_arm
from limner.motion.arm.robot import SAFE, Robot
from limner.motion.cost import seconds as plotter_seconds
from limner.motion.machine import load_machine
from limner.pipeline import Session, Settings
from limner.simulation.outcome import Simulation, follow, simulate
from limner.simulation.pictures import overlay_picture
from limner.simulation.render import Camera, Scene
from limner.simulation.settings import FaultSettings
from limner.simulation.thesis import MISS_MM, thesis_motion
from limner.targets.image import to_rgb
from limner.targets.sheet import Tile, to_sheet
from limner.types import Drawing, Face, Floats, Pen, Photo, Strokes
from limner.vision.edges import gabor_edges
from limner.vision.scale import Working
from limner.vision.skeleton import skeletonize
from limner.vision.trace import TraceSettings, trace
from limner.vision.trim import trim

Rgb = NDArray[np.uint8]

THESIS_S_PER_POINT = 1.5
"""Section 4.4."""

INK, DOT = (20, 20, 24), (196, 62, 30)
_SHIFT = 4
_ENLARGED, _AROUND_PX = 3, 8.0


@dataclass(frozen=True)
class Timed:
    """A drawing and how long it takes.

    Attributes:
        name: of the drawing.
        points: it has.
        ink_mm: its length.
        plan: of the arm.
        plotter_s: an AxiDraw's time.
        thesis: the thesis's, in words; may be empty.
    """

    name: str
    points: int
    ink_mm: float
    plan: ArmPlan
    plotter_s: float
    thesis: str = ""


def orders(view: Working, settings: Settings) -> Rgb:
    """Figure 4.3: the pixels of each component connected as MATLAB lists them, and as they are traced."""
    skeleton = _thesis_skeleton(view, settings)
    count, labels = cv2.connectedComponents(skeleton.astype(np.uint8), connectivity=8)
    columns, rows = np.nonzero(skeleton.T)
    listed = [np.column_stack([columns, rows])[labels[rows, columns] == k] for k in range(1, count)]
    traced = trace(skeleton, _every_pixel())
    lines = [line.astype(np.float64) for line in listed if len(line) > 1]
    return to_sheet(
        [
            Tile(_drawn(lines, width=1), "column by column", "as the components list them"),
            Tile(_drawn(traced), "traced", f"{sum(map(len, traced))} points"),
        ],
        columns=2,
        tile_px=620,
    )


def thinned_points(view: Working, settings: Settings, robot: Robot) -> tuple[Rgb, list[Timed]]:
    """Figure 4.4: a drawing with all its points, and with half of them, and the times of both."""
    skeleton = _thesis_skeleton(view, settings)
    every = trace(skeleton, _every_pixel())
    fewer = trace(skeleton, _every_pixel().replace(step_px=_half_step(skeleton, every)))
    timed, tiles = [], []
    for name, lines, thesis in (
        ("all points", every, "2500 points, an hour"),
        ("far enough apart", fewer, "half of them, 30 minutes"),
    ):
        drawing = _on_page(lines, view, settings)
        timed.append(_timed(name, drawing, robot, settings, thesis))
        note = f"{timed[-1].points} points; {timed[-1].plan.trajectory.t_s[-1]:.0f} s with {robot.name}"
        tiles.append(Tile(_drawn(lines, dots=True), name, note))
    return to_sheet(tiles, columns=2, tile_px=620), timed


def drawn_by_the_arm(
    photo: Photo, face: Face, settings: Settings, robot: Robot, budgets: Sequence[int] = (250, 600)
) -> tuple[Rgb, Rgb, list[Timed]]:
    """Figures 4.5 and 4.2: line drawings, what the simulated arm makes of them in both ways, and its starting pose."""
    session, tiles, timed = Session(photo), [], []
    start: Rgb | None = None
    for points in budgets:
        drawing = session.draw(settings, face=face, points=points).drawing
        timed.append(_timed(f"at most {points} points", drawing, robot, settings, f"{points} points, 20 minutes"))
        ours = simulate(timed[-1].plan.trajectory, robot, settings.simulation, drawing)
        start = _pose(ours, robot) if start is None else start
        misses = settings.simulation.replace(fault=FaultSettings(repeat_mm=MISS_MM, seed=0), stiff=False)
        tiles += [
            Tile(to_rgb(drawing, 6.0), f"the drawing, {timed[-1].points} points"),
            _theirs(ours, drawing.pen),
            _outcome("limner's way", follow(ours.trajectory, robot, ours.sheet, misses), drawing.pen),
        ]
    assert start is not None
    return to_sheet(tiles, columns=3, tile_px=520), start, timed


def time_table(timed: Sequence[Timed]) -> Grid:
    """What the thesis's arm needed, what it would need at 1.5 s a point, and what is needed here."""
    rows = [
        (
            one.name,
            str(one.points),
            f"{one.ink_mm / 1000:.2f} m",
            one.thesis or "-",
            f"{one.points * THESIS_S_PER_POINT / 60:.0f} min",
            f"{one.plan.trajectory.t_s[-1]:.0f} s",
            f"{one.plan.report()['draw_s']:.0f} s",
            f"{one.plotter_s:.0f} s",
        )
        for one in timed
    ]
    heads = ("drawing", "points", "ink", "thesis", "at 1.5 s a point", "Dumbo, here", "of it pen down", "AxiDraw")
    note = (
        "Dumbo, here: planned within its published limits (38 deg/s, 1.66 rad/s2), on A5, from the safe pose and back;"
        " simulated, not run on the arm. AxiDraw: planned."
    )
    return Grid("Drawing times", heads, tuple(rows), note)


def _thesis_skeleton(view: Working, settings: Settings) -> NDArray[np.bool_]:
    """What section 3.6 ends with: Gabor filters at the original scale, trimmed by landmarks and length, thinned."""
    edges = gabor_edges(view.photo, view.face, settings.gabor.replace(guided=False, irises=False, hairline=1.0))
    return skeletonize(trim(edges, view.face, settings.trim).mask)


def _every_pixel() -> TraceSettings:
    return TraceSettings().replace(smooth_px=0.0, step_px=0.0, tolerance_px=0.0, shortest_px=2.0)


def _half_step(skeleton: NDArray[np.bool_], every: Sequence[Floats]) -> float:
    """The least distance between points that leaves half of them at most [px]."""
    wanted = sum(map(len, every)) / 2
    for step in np.arange(1.1, 6.0, 0.1):
        if sum(map(len, trace(skeleton, _every_pixel().replace(step_px=float(step))))) <= wanted:
            return float(step)
    return 6.0


def _on_page(lines: Sequence[Floats], view: Working, settings: Settings) -> Drawing:
    strokes = Strokes(tuple(lines), ("body",) * len(lines), np.ones(len(lines)), view.photo.size_px)
    placed = compose(strokes, settings.page.page(), settings.compose, settings.page.pen())
    return order(placed, settings.order)


def _timed(name: str, drawing: Drawing, robot: Robot, settings: Settings, thesis: str) -> Timed:
    ink = float(sum(np.hypot(*np.diff(line, axis=0).T).sum() for line in drawing.lines_mm))
    plan = plan_arm(drawing, robot, settings.arm)
    points = sum(map(len, drawing.lines_mm))
    return Timed(name, points, ink, plan, plotter_seconds(drawing, load_machine("axidraw")), thesis)


def _theirs(ours: Simulation, pen: Pen) -> Tile:
    """The thesis's way to draw the same, with a sprung pen, by an arm that misses."""
    title = "the thesis's way"
    down = ours.trajectory.q[ours.trajectory.down][0]
    misses = ours.settings.replace(fault=FaultSettings(repeat_mm=MISS_MM, seed=0), stiff=False)
    try:
        motion = thesis_motion(ours.plan_mm, ours.sheet, ours.robot.forward(down)[:3, :3], ours.robot, ours.press_mm)
    except CannotDraw as error:
        return Tile(np.full((300, 240, 3), 255, np.uint8), title, str(error))
    return _outcome(title, follow(motion, ours.robot, ours.sheet, misses), pen)


def _outcome(title: str, made: Simulation, pen: Pen) -> Tile:
    report = made.report()
    told = f"{report['seconds']:.0f} s, {report['travel_ink_mm']:.0f} mm of ink in travel"
    return Tile(overlay_picture(made, pen), title, told)


def _pose(made: Simulation, robot: Robot) -> Rgb:
    """The robot at rest over its sheet, seen from where all of it is in view."""
    page, q = made.paper.page, robot.pose(SAFE)
    corners = np.array([[0.0, 0.0], [page.width_mm, page.height_mm]])
    seen = np.concatenate([robot.frames(q)[:, :3, 3], robot.forward(q)[None, :3, 3], made.paper.points_m(corners)])
    middle, size = 0.5 * (seen.min(0) + seen.max(0)), float(np.linalg.norm(np.ptp(seen, axis=0)))
    out = made.paper.points_m(corners).mean(0)[:2] - robot.frames(q)[0, :2, 3]
    out /= np.linalg.norm(out)
    back = np.array([*(0.7 * out - 0.45 * np.array([out[1], -out[0]])), 0.75])
    paper = np.full((round(page.height_mm * 6), round(page.width_mm * 6), 3), 255, np.uint8)
    scene = Scene(robot, made.paper, Camera.looking(middle + 1.9 * size * back, middle, 42.0, (900, 700)))
    return scene.picture(q, robot.forward(q)[:3, 3], paper)


def _drawn(lines: Sequence[Floats], dots: bool = False, width: int = 3) -> Rgb:
    """Polylines (n, 2) on white, at three times their size, with a little white around."""
    points = np.concatenate(list(lines))
    low, high = points.min(axis=0) - _AROUND_PX, points.max(axis=0) + _AROUND_PX
    across, high_px = np.ceil(_ENLARGED * (high - low)).astype(int).tolist()
    picture = np.full((high_px, across, 3), 255, np.uint8)
    fixed = [np.rint(_ENLARGED * (line - low) * 2**_SHIFT).astype(np.int32) for line in lines]
    cv2.polylines(picture, fixed, False, INK, width, cv2.LINE_AA, _SHIFT)
    if dots:
        for point in np.concatenate(fixed).tolist():
            cv2.circle(picture, point, 3 << _SHIFT, DOT, -1, cv2.LINE_AA, _SHIFT)
    return picture

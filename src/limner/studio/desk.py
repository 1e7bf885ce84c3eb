"""The work of the computing process: a task's name and its arguments go in, plain data and bytes come out."""

from __future__ import annotations

import contextlib
import dataclasses
import time
from collections import OrderedDict, defaultdict, deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from limner import storage
from limner.drawing.measure import measure
from limner.errors import LimnerError, NoFace
from limner.motion.cost import costs
from limner.motion.machine import load_machine
from limner.pipeline import Portrait, Session, Settings, find_faces, refine_face
from limner.studio import exports, frames, menu, plans
from limner.studio.wishes import face_of, settings_of, template
from limner.targets.image import encode_jpeg, encode_png
from limner.types import Drawing, Face, Photo
from limner.vision.landmarks import choose
from limner.vision.lines import LineSettings
from limner.vision.photo import load_photo, shrink_photo
from limner.vision.quality import photo_notes

SIDE_PX = 2048
"""A larger photo is looked at in this size; a face is drawn from 128 px between its eyes."""

KEPT_BYTES = 4 * 2**20
"""A longer file is kept as a JPEG of the size that is looked at."""

DRAFT_KICKS, DRAFT_SIZE = 2, 0.7
"""How long the order of a draft is looked for, and in what part of its size a photo is looked at for it, where anew."""

LOOKS = ("style", "refine", "refinement", "detect", *(field.name for field in dataclasses.fields(LineSettings)))
"""Settings by which a photo is looked at anew; what the others change costs little."""

_HELD, _KEPT = 4, 6  # photos, and results of each stage of one, such as of each style


class NotHeld(Exception):
    """A photo that is not on the desk: new, or gone for later ones."""


@dataclass(frozen=True)
class Held:
    """A photo on the desk.

    Attributes:
        photo: upright, at most ``SIDE_PX``.
        faces: found in it, largest first.
        session: that draws it.
    """

    photo: Photo
    faces: tuple[Face, ...]
    session: Session


class Desk:
    """What the process holds between tasks: the latest photos."""

    def __init__(self, base: Settings, going_on: Callable[[], None]) -> None:
        """An empty desk.

        Args:
            base: settings where the page says nothing.
            going_on: called between stages; raises when the task is not wanted any more.
        """
        self._base, self._going_on = base, going_on
        self._held: OrderedDict[str, Held] = OrderedDict()
        self._looked: defaultdict[str, deque[Any]] = defaultdict(lambda: deque(maxlen=_KEPT))

    def warm(self) -> None:
        """Load models and compilers' caches before anybody waits for them: draw a face that is none."""
        grey = np.random.default_rng(0).integers(90, 160, (240, 200, 3), np.uint8)
        photo = Photo(grey)
        with contextlib.suppress(LimnerError):
            find_faces(photo, self._base)
            made = Session(photo).draw(self._base, face=face_of(template([50, 70, 150, 190]), photo.size_px))
            refine_face(photo, made.face, self._base)
            self._report(made)

    def photo(self, name: str, data: bytes) -> dict[str, Any]:
        """Take a photo in; what was found in it, the JPEG that is shown, and the file that is kept."""
        photo = shrink_photo(load_photo(data, still=True), SIDE_PX)
        if len(data) > KEPT_BYTES:
            # What is kept is what is drawn from, before and after this process is replaced.
            data = encode_jpeg(photo.rgb, 95)
            photo = load_photo(data)
        self._going_on()
        faces = find_faces(photo, self._base)
        self._held[name] = Held(photo, faces, Session(photo, _KEPT, self._going_on))
        while len(self._held) > _HELD:
            gone, _ = self._held.popitem(last=False)
            self._looked.pop(gone, None)
        return {"about": self._found(photo, faces), "jpeg": encode_jpeg(photo.rgb), "data": data}

    def _found(self, photo: Photo, faces: tuple[Face, ...]) -> dict[str, Any]:
        width, height = photo.size_px
        told: dict[str, Any] = {"width": width, "height": height, "faces": [], "notes": []}
        try:
            first = choose(faces, 1, photo, self._base.detect)
        except NoFace as error:
            return told | {"error": str(error)}
        told["faces"] = [storage.to_fields(self._refined(photo, face)) for face in faces]
        return told | {"notes": list(photo_notes(photo, first))}

    def _refined(self, photo: Photo, face: Face) -> Face:
        return refine_face(photo, face, self._base) if face.frontal else face

    def draw(self, wish: dict[str, Any], *, draft: bool = False) -> dict[str, Any]:
        """Draw; the report and the frame of the strokes."""
        began = time.process_time()
        portrait = self._draw(wish, draft)
        self._going_on()
        report = self._report(portrait)
        report["cpu_s"] = time.process_time() - began
        drawn = {"report": report, "frame": frames.lines_frame(portrait.drawing, wish["rev"])}
        if "plan" in wish.get("want", ()):
            # It is planned in another process, which takes longer than anybody waits for a preview.
            drawn |= {"npz": storage.to_npz(portrait.drawing), "settings": portrait.settings.to_dict()}
        return drawn

    def plan(self, npz: bytes, by: dict[str, Any], settings: dict[str, Any], rev: int = 0) -> dict[str, Any]:
        """How a machine or a robot draws a drawing: the plan, and its frame or why there is none."""
        return plans.planned(storage.from_npz(Drawing, npz), by, self._settings(settings), rev)

    def lines(self, npz: bytes) -> bytes:
        """The frame of a drawing that was kept."""
        return frames.lines_frame(storage.from_npz(Drawing, npz), 0)

    def export(self, npz: bytes, kind: str, settings: dict[str, Any], **by: str | None) -> bytes:
        """The file of a drawing that was kept."""
        return exports.exported(
            storage.from_npz(Drawing, npz), kind, self._settings(settings), by.get("machine"), by.get("robot")
        )

    def picture(self, wish: dict[str, Any]) -> bytes:
        """The photo in colours as the style of a drawing pictures it, as PNG."""
        return encode_png(self._draw(wish, False).picture())

    def prepared(self, npz: bytes, robot: str | None, settings: dict[str, Any], frame_only: bool) -> bytes:
        """What is sent of a drawing: itself, or the motion of a robot's joints; or of the frame around it."""
        drawing = storage.from_npz(Drawing, npz)
        if robot is None:
            return storage.to_npz(plans.frame_of(drawing)) if frame_only else npz
        return storage.to_npz(plans.trajectory(drawing, robot, self._settings(settings), frame_only=frame_only))

    def robot(self, name: str) -> dict[str, Any]:
        """A robot as the page shows it."""
        return plans.robot_fields(name)

    def urdf(self, name: str) -> bytes:
        """A robot's own description."""
        return plans.urdf(name)

    def _settings(self, tree: dict[str, Any]) -> Settings:
        """A whole tree, of a drawing that was kept; else the usual one."""
        return Settings.from_dict(tree) if tree else self._base

    def place(self, wanted: dict[str, Any], size_px: tuple[int, int]) -> Any:
        """A face placed by hand: by its points, or as a template in a box."""
        given = wanted.get("points_px")
        return storage.to_fields(face_of(template(wanted.get("box_px")) if given is None else given, size_px))

    def options(self) -> dict[str, Any]:
        """All that the page offers."""
        return menu.options(self._base)

    def variants(self, wish: dict[str, Any], kind: str) -> list[dict[str, Any]]:
        """What stands side by side, each with the settings that make it."""
        return menu.variants(kind, wish, self._base)

    def keep(self, wish: dict[str, Any]) -> dict[str, Any]:
        """Draw; the report, the settings, and the drawing itself."""
        portrait = self._draw(wish, False)
        about = {"report": self._report(portrait), "settings": portrait.settings.to_dict()}
        return {"about": about, "npz": storage.to_npz(portrait.drawing)}

    def _draw(self, wish: dict[str, Any], draft: bool) -> Portrait:
        held, settings = self._at(wish["photo"]), settings_of(self._base, wish.get("settings") or {})
        points, number = wish.get("points_px"), 1 + int(wish.get("face") or 0)
        looks = ([getattr(settings, name) for name in LOOKS], points, number)
        if draft:
            settings = drafted(settings, smaller=looks not in self._looked[wish["photo"]])
        else:
            self._looked[wish["photo"]].appendleft(looks)
        if points is not None:
            return held.session.draw(settings, face=face_of(points, held.photo.size_px))
        return held.session.draw(settings, number=number)

    def _at(self, name: str) -> Held:
        if name not in self._held:
            raise NotHeld(name)
        self._held.move_to_end(name)
        return self._held[name]

    def _report(self, portrait: Portrait) -> dict[str, Any]:
        return drawing_report(portrait.drawing, portrait.settings.machine) | {
            "style": portrait.settings.style,
            "likeness": portrait.likeness,
            "page_from_photo": portrait.page_from_photo.tolist(),
            "points_px": portrait.face.points_px.tolist(),
            "compute_s": sum(portrait.seconds.values()),
        }


def drafted(settings: Settings, *, smaller: bool) -> Settings:
    """Settings for a drawing that shall be there soon, perhaps of a smaller photo."""
    order = settings.order.replace(kicks=min(DRAFT_KICKS, settings.order.kicks))
    scale = settings.scale
    if smaller:
        scale = scale.replace(outer_eye_px=max(32.0, DRAFT_SIZE * scale.outer_eye_px))
    return settings.replace(order=order, scale=scale)


def drawing_report(drawing: Drawing, machine: str) -> dict[str, Any]:
    """What a drawing costs on a machine, and its page."""
    told = costs(drawing, load_machine(machine))
    return {
        **dataclasses.asdict(measure(drawing)),
        "seconds": told.seconds,
        "minutes": told.seconds / 60,
        "page": dataclasses.asdict(drawing.page),
        "pen_mm": drawing.pen.width_mm,
        "pens": [{"name": pen.name, "width_mm": pen.width_mm, "colour": pen.hex} for pen in drawing.pens],
    }

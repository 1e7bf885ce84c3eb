"""A photo's file goes in; how long each stage of drawing it takes, and the memory it needs at most, come out."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from limner.pipeline import Session

_RESET, _STATUS = Path("/proc/self/clear_refs"), Path("/proc/self/status")


@dataclass(frozen=True)
class Stage:
    """One stage of one drawing.

    Attributes:
        name: of the stage.
        seconds: it took.
        peak_mb: most memory of the process during it, libraries and models included; None where it is not to be had.
    """

    name: str
    seconds: float
    peak_mb: float | None


def stages_of(photo: Path) -> list[Stage]:
    """Draw a photo in a process of its own, for the second time, so that libraries and models are loaded."""
    program = f"from limner.evaluate.stages import tell; tell({str(photo)!r})"
    done = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    return [Stage(*fields) for fields in json.loads(done.stdout)]


def tell(photo: str) -> None:
    """What the process of ``stages_of`` does: print the stages as JSON."""
    Session(photo).draw()
    peaks: list[float | None] = []

    def between() -> None:
        peaks.append(_peak_mb())

    portrait = Session(photo, before=between).draw()
    between()
    rows = zip(portrait.seconds.items(), peaks[1:], strict=True)
    print(json.dumps([[name, seconds, peak] for (name, seconds), peak in rows]))


def _peak_mb() -> float | None:
    """The most memory since this was asked last, where the system keeps account of it (Linux)."""
    try:
        (line,) = (line for line in _STATUS.read_text().splitlines() if line.startswith("VmHWM:"))
        _RESET.write_text("5")
    except (OSError, ValueError):
        return None
    return int(line.split()[1]) / 1024

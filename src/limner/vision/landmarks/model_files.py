"""The name of a model that others made goes in, the file that the user keeps of it comes out, or where to get it."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Any, NamedTuple

import cv2

from limner.errors import BadInput
from limner.storage import read_bytes

FOLDER = "LIMNER_MODELS"
"""The environment variable that names the folder of models."""


class ModelFile(NamedTuple):
    """A model that the user fetches.

    Attributes:
        what: it is called.
        about: how large it is, its licence.
        pattern: of its file name, with ``*`` where names differ.
        source: where to get it.
        limit: more bytes are something else.
        sha256: of the files that were published, the newest first.
    """

    what: str
    about: str
    pattern: str
    source: str
    limit: int
    sha256: tuple[str, ...]

    @property
    def get(self) -> str:
        """How to come by it, as the end of a message."""
        return f"get {self.pattern} from {self.source}"

    def wrong(self, file: Path, why: str) -> BadInput:
        """The error of a file that is not this model."""
        return BadInput(f"{file}: not {self.what}, or damaged ({why}); {self.get}")


def in_folder(model: ModelFile) -> Path | None:
    """The model in the folder that the environment names, or in a folder in it; the last by name of several.

    Raises:
        BadInput: the environment names something that is no folder.
    """
    folder = os.environ.get(FOLDER, "")
    if not folder:
        return None
    if not Path(folder).is_dir():
        raise BadInput(f"{FOLDER}: {folder} is no folder; expected one with {model.pattern} in it, or nothing")
    for pattern in (model.pattern, f"*/{model.pattern}"):
        if files := sorted(Path(folder).glob(pattern)):
            return files[-1]
    return None


def required(model: ModelFile, path: str, option: str) -> Path:
    """The model at the path, or in the folder if that is empty.

    Args:
        model: which.
        path: that the user gave, perhaps empty.
        option: by which a path is given, for the message.

    Raises:
        BadInput: there is none.
    """
    file = Path(path) if path else in_folder(model)
    if file is None:
        raise BadInput(
            f"{model.what} ({model.about}) is not here: {model.get},"
            f" then name it with {option} or put it into a folder and set {FOLDER} to that folder"
        )
    return file


def check(model: ModelFile, file: Path, trust: bool) -> None:
    """Refuse what is not the published file: OpenCV's readers of networks can crash on a damaged or hostile one.

    Args:
        model: that the file should be.
        file: to be read.
        trust: that the user asks to use any file.

    Raises:
        BadInput: it cannot be read, is too large for such a model, or not the published one.
    """
    digest = hashlib.sha256(read_bytes(file, model.limit)).hexdigest()
    if not trust and digest not in model.sha256:
        raise model.wrong(
            file, f"SHA-256 {digest[:8]}..., published {model.sha256[0][:8]}...; detect.mediapipe.trust uses any file"
        )


class Quiet:
    """While it lasts OpenCV's networks write nothing to stderr: what went wrong is in the error they raise."""

    _SILENT = 0
    _logging: Any = getattr(cv2.utils, "logging", cv2)  # OpenCV 4 has the two functions in cv2 itself

    def __enter__(self) -> None:
        self._level = self._logging.getLogLevel()
        self._logging.setLogLevel(self._SILENT)

    def __exit__(self, *_: object) -> None:
        self._logging.setLogLevel(self._level)

"""The path or URL of a photo goes in; its bytes, their hash, and the face given beside it come out."""

from __future__ import annotations

import hashlib
import os

from limner import storage
from limner.batch import remote
from limner.errors import BadInput
from limner.types import Face
from limner.vision.landmarks.annotation import read_faces

MOST_BYTES = 512 * 2**20
"""A larger file is no photo."""

SIDECARS = (".pts", ".json", ".csv")
"""Files of the photo's name that hold its landmarks, the first that is there."""


class Unread(BadInput):
    """The bytes of a photo could not be had this time: next time they perhaps can."""


def read(photo: str) -> bytes:
    """The bytes of a photo.

    Raises:
        Unread: it is not there, is no file, or may not be read.
    """
    if remote.is_url(photo):
        try:
            return remote.read(photo, MOST_BYTES)
        except BadInput as error:
            raise Unread(str(error)) from error
    # Opening a pipe would wait for its other end for ever.
    if os.path.exists(photo) and not os.path.isfile(photo):
        raise Unread(f"{photo}: cannot be read (not a file)")
    try:
        return storage.read_bytes(photo, MOST_BYTES)
    except BadInput as error:
        raise Unread(str(error)) from error


def digest(data: bytes) -> str:
    """SHA-256 of bytes, in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


def digest_of(photo: str) -> str:
    """SHA-256 of a photo's bytes.

    Raises:
        Unread: they cannot be had.
    """
    return digest(read(photo))


def stamp(photo: str) -> str | None:
    """Size and time of change: while these stay, so does the hash. None where they are not to be had."""
    if remote.is_url(photo):
        return remote.stamp(photo)
    try:
        about = os.stat(photo)
    except (OSError, ValueError):
        return None
    return f"{about.st_size} {about.st_mtime_ns} {about.st_ino}"


def face_beside(photo: str) -> Face | None:
    """The face that a file of the photo's name holds (see ``SIDECARS``), the largest; None where there is no file.

    Raises:
        BadInput: the file holds no landmarks.
    """
    if remote.is_url(photo):
        return None
    for suffix in SIDECARS:
        path = os.path.splitext(photo)[0] + suffix
        if os.path.isfile(path) and path != photo:
            faces = read_faces(path)
            if not faces:
                raise BadInput(f"{path}: no landmarks in it")
            return faces[0]
    return None

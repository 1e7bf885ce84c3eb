"""A photo's name and hash go in; the name of its drawing comes out, never the same for two and the same every time."""

from __future__ import annotations

import os
import unicodedata
from urllib.parse import unquote

from limner.batch import remote

_MOST_BYTES = 80
_MARKS = "-_.()+"
_HEX = 12


def drawing_name(photo: str, mark: str) -> str:
    """Name, without suffix, of what is drawn from a photo.

    Letters and digits of any script stay; what shells, other systems and terminals trip over becomes ``_``.

    Args:
        photo: its path or URL.
        mark: a hash, in hexadecimal, of what is drawn; its beginning keeps photos of one name apart.
    """
    path = unquote(photo.partition("?")[0]) if remote.is_url(photo) else photo
    stem, _ = os.path.splitext(os.path.basename(path))
    kept = "".join(_plain(sign) for sign in unicodedata.normalize("NFC", stem))
    return f"{_shortened(kept.strip('._-') or 'photo')}-{mark[:_HEX]}"


def _plain(sign: str) -> str:
    return sign if sign.isalnum() or unicodedata.category(sign)[0] == "M" or sign in _MARKS else "_"


def _shortened(name: str) -> str:
    """As many signs as fit into the bytes that a file's name may have beside the rest."""
    return name.encode()[:_MOST_BYTES].decode(errors="ignore")

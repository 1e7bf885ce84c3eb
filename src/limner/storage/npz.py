"""Arrays by name go in; the bytes of an npz archive come out, always the same; and back, without trust in them."""

from __future__ import annotations

import io
import math
import re
import zipfile
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput, LimnerError

_HEADER = re.compile(
    rb"\{'descr': '([<>|][biufU]\d{1,9})', 'fortran_order': (True|False), 'shape': \(([\d, ]*)\), \}\s*"
)


def pack_npz(arrays: Mapping[str, Any]) -> bytes:
    """An npz archive of the arrays; the same arrays give the same bytes (no time stamps)."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            buffer = io.BytesIO()
            np.lib.format.write_array(buffer, np.asanyarray(array), allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), buffer.getvalue(), zipfile.ZIP_DEFLATED)
    return out.getvalue()


def unpack_npz(data: bytes, name: str = "npz", limit: int = 2**30) -> dict[str, Any]:
    """The arrays of an npz archive; nothing in it is ever executed.

    Raises:
        BadInput: no such archive, an object array, or more than ``limit`` bytes when unpacked.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            if sum(info.file_size for info in members) > limit:
                raise BadInput(f"{name}: unpacks to more than {limit // 2**20} MB, the limit")
            # Others pack a gigabyte into a kilobyte, and numpy writes none of them.
            if not {info.compress_type for info in members} <= {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}:
                raise BadInput(f"{name}: is packed in a way that numpy does not write; save it again")
            return {info.filename.removesuffix(".npy"): _array(archive.read(info)) for info in members}
    except LimnerError:
        raise
    except Exception as error:  # damaged archives make zipfile raise errors of many kinds
        raise BadInput(f"{name}: not a readable npz file ({error})") from error


def _array(content: bytes) -> NDArray[Any]:
    """The array in an npy file (NumPy's NEP 1) of numbers or texts.

    Raises:
        ValueError: it is damaged, holds something else, or is not as long as it says.
    """
    start = 10 if content[6:7] == b"\x01" else 12
    end = start + int.from_bytes(content[8:start], "little")
    found = _HEADER.fullmatch(content[start:end])
    if content[:6] != b"\x93NUMPY" or found is None:
        raise ValueError("holds something else than plain arrays")
    dtype, shape = np.dtype(found[1].decode()), tuple(map(int, found[3].replace(b",", b" ").split()))
    if math.prod(shape) * dtype.itemsize != len(content) - end:
        raise ValueError("an array is not as long as it says")
    order: Literal["F", "C"] = "F" if found[2] == b"True" else "C"
    array = np.ndarray(shape, dtype, content, end, order=order).copy()
    if dtype.kind == "U" and array.nbytes and array.reshape(-1).view(f"{dtype.str[0]}u4").max() > 0x10FFFF:
        raise ValueError("a text is damaged")
    return array.view(np.uint8) != 0 if dtype.kind == "b" else array

"""An input and a source of chance go in; another input, likely to be wrong in one place, comes out."""

from __future__ import annotations

import io
import random
import re
import warnings
import zipfile
import zlib
from collections.abc import Callable

import numpy as np

LARGEST = 100_000
"""Bytes of an input."""

NUMBERS = [
    *(b"0", b"-1", b"1e999", b"-1e308", b"nan", b"inf", b"-inf", b"1e-320", b"2147483648", b"18446744073709551616"),
    *(b"1.1.1", b"--", b"9" * 400, b"9" * 5000, b"1e", b"0x1", b"true", b"null", b'"a"', b"[]", b"{}", b""),
]
"""What may stand where a number is expected."""

WORDS = [
    *(
        b"\x00",
        b"\xff\xfe",
        b"\xed\xa0\x80",
        b"\\ud800",
        b"\x1b[31m",
        b"\n",
        b"\r\n",
        b"\n\n\n",
        b",",
        b'"',
        b"'",
        b";",
    ),
    *(b"(" * 60, b"[" * 3000, b"{" * 3000, b'{"a":' * 2000, b"<g>" * 200, b"&a;", b"%s", b"{0}", b"../", b"://", b"="),
]
"""What stands where nobody expects it."""

_NUMBER = re.compile(rb"[-+]?\d[\d.]*(?:e[-+]?\d+)?", re.IGNORECASE)
_WORD = re.compile(rb"[A-Za-z_][\w-]*")


def mutated(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    """A few changes; an npz archive is opened, changed within and closed again, so that its check sums are right.

    Args:
        data: to begin with.
        chance: what decides.
        others: inputs of the same kind, from which pieces may be taken.
    """
    if data[:2] == b"PK" and chance.random() < 0.8:
        return _in_archive(data, chance)
    if data[:4] == b"\x89PNG" and chance.random() < 0.7:
        return _in_png(data, chance)
    for _ in range(chance.choice([1, 1, 1, 2, 3, 8])):
        data = chance.choice(_CHANGES)(data, chance, others)[:LARGEST]  # each may make it fifty times as long
    return data


def _in_archive(data: bytes, chance: random.Random) -> bytes:
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = [(name, archive.read(name)) for name in archive.namelist()]
    except Exception:  # of damaged archives zipfile raises errors of many kinds
        return _flip(data, chance, [])
    k = chance.randrange(len(members)) if members else 0
    if members:
        name, content = members[k]
        what = chance.randrange(6)
        if what == 0:
            del members[k]
        elif what == 1:
            members.append((chance.choice(members)[0], content))
        elif what == 2:
            members[k] = (name, _odd_array(chance))
        elif what == 3:
            members[k] = (name, content[:10] + _number(content[10:], chance, []))
        else:
            members[k] = (name, chance.choice(_CHANGES)(content, chance, []))
    out = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        warnings.simplefilter("ignore")  # of names that come twice
        for name, content in members:
            archive.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)
    return out.getvalue()


def _odd_array(chance: random.Random) -> bytes:
    arrays = [
        *(np.zeros(0), np.float64(np.nan), np.array([np.inf, 1]), np.zeros((2, 0)), np.full((3, 2), 1e300)),
        *(np.array("{"), np.array("[" * 3000), np.array(["a", "b"]), np.array(b"x"), np.array([1 + 2j])),
        *(np.array(["NaT"], "M8[s]"), np.zeros(2, "i4,f8"), np.array(-(2**63)), np.array(True), np.zeros((1,) * 30)),
        *(
            np.arange(5)[::-1],
            np.array(2**64 - 1, np.uint64),
            np.float16(1),
            np.zeros((68, 2), ">f8"),
            np.zeros(4, "V3"),
        ),
    ]
    out = io.BytesIO()
    np.lib.format.write_array(out, np.asanyarray(chance.choice(arrays)), allow_pickle=False)
    return out.getvalue()


def _in_png(data: bytes, chance: random.Random) -> bytes:
    """A change in one of the chunks, with its check sum put right."""
    chunks, at = [], 8
    while at + 12 <= len(data):
        size = int.from_bytes(data[at : at + 4], "big")
        chunks.append((data[at + 4 : at + 8], data[at + 8 : at + 8 + size]))
        at += 12 + size
    k = chance.randrange(max(1, len(chunks)))
    if chunks:
        kind, content = chunks[k]
        chunks[k] = (kind, chance.choice([_flip, _number_bytes, _cut])(content, chance, []))
    body = (len(c).to_bytes(4, "big") + k + c + zlib.crc32(k + c).to_bytes(4, "big") for k, c in chunks)
    return data[:8] + b"".join(body)


def _flip(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    if not data:
        return bytes([chance.randrange(256)])
    k = chance.randrange(len(data))
    return data[:k] + bytes([data[k] ^ 1 << chance.randrange(8)]) + data[k + 1 :]


def _number_bytes(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    k, size = chance.randrange(len(data) + 1), chance.choice([1, 2, 4, 8])
    value = chance.choice([0, 1, 2 ** (8 * size) - 1, 2 ** (8 * size - 1), 2 ** (8 * size - 1) - 1])
    return data[:k] + value.to_bytes(size, chance.choice(["big", "little"])) + data[k + size :]


def _cut(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    a, b = sorted(chance.randrange(len(data) + 1) for _ in range(2))
    return data[:a] + data[b:] if chance.random() < 0.7 else data[:a]


def _again(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    a, b = sorted(chance.randrange(len(data) + 1) for _ in range(2))
    return data[:b] + data[a:b] * chance.choice([1, 1, 2, 50]) + data[b:]


def _other(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    other = chance.choice(others) if others else data
    return data[: chance.randrange(len(data) + 1)] + other[chance.randrange(len(other) + 1) :]


def _number(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    return _replaced(data, _NUMBER, chance.choice(NUMBERS), chance)


def _word(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    known = _WORD.findall(data) or [b""]
    return _replaced(
        data, _WORD, chance.choice([chance.choice(WORDS), chance.choice(known), chance.choice(NUMBERS)]), chance
    )


def _put(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    k = chance.randrange(len(data) + 1)
    return data[:k] + chance.choice(WORDS + NUMBERS) + data[k:]


def _replaced(data: bytes, pattern: re.Pattern[bytes], by: bytes, chance: random.Random) -> bytes:
    found = list(pattern.finditer(data[:LARGEST]))
    if not found:
        return data + by
    match = chance.choice(found)
    return data[: match.start()] + by + data[match.end() :]


_CHANGES: list[Callable[[bytes, random.Random, list[bytes]], bytes]] = [
    *(_flip, _number_bytes, _cut, _again, _other, _number, _number, _number, _word, _word, _put)
]

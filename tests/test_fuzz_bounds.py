"""A small hostile file costs neither ten seconds of the processor nor a gigabyte, whatever reads it."""

from __future__ import annotations

import io
import os
import pickle
import resource
import struct
import subprocess
import sys
import zipfile
import zlib
from pathlib import Path

import pytest
from PIL import Image

CPU_S = 10
BYTES = 2**30

SVG = b'<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100">'


def used(first, times, depth):
    """Each level uses the one below several times."""
    levels = [b'<g id="a0">%s</g>' % first]
    levels += [b'<g id="a%d">%s</g>' % (k, b'<use href="#a%d"/>' % (k - 1) * times) for k in range(1, depth)]
    return SVG + b"<defs>" + b"".join(levels) + b'</defs><use href="#a%d"/></svg>' % (depth - 1)


def laughs(within):
    entities = b"".join(b'<!ENTITY a%d "%s">' % (k, b"&a%d;" % (k - 1) * 10) for k in range(1, 9))
    return b'<!DOCTYPE x [<!ENTITY a0 "ha">' + entities + b"]>" + within


def png(width, height, rows, bits):
    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    head = struct.pack(">IIBBBBB", width, height, bits, 0, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(bytes(rows), 9))
        + chunk(b"IEND", b"")
    )


def flat(kind, side, **more):
    out = io.BytesIO()
    Image.new("RGB", (side, side)).save(out, kind, **more)
    return out.getvalue()


def npz(how, shape, size, members=1):
    header = b"{'descr': '|u1', 'fortran_order': False, 'shape': (%d,), }" % shape
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", how) as archive:
        for k in range(members):
            archive.writestr(
                f"a{k}.npy", b"\x93NUMPY\x01\x00" + struct.pack("<H", 100) + header.ljust(100) + bytes(size)
            )
    return out.getvalue()


CASES = {
    "svg": [
        used(b'<path d="M0 0L1 1" stroke="red"/>', 3, 12),
        used(b'<path d="M0 0%s" stroke="red"/>' % (b"l1 1" * 60), 9, 5),
        used(b'<g transform="rotate(1)"><circle r="9e5"/></g>', 3, 8),
        SVG + b"".join(b'<circle r="%de6"/>' % (k % 9 + 1) for k in range(40)) + b"</svg>",
        SVG + b'<path d="M0 0' + b"C9e8 0 0 9e8 9 9" * 40 + b'"/></svg>',
        SVG + b'<circle r="1" transform="' + b"scale(2)" * 100 + b'"/></svg>',
        SVG + b'<g transform="scale(9)rotate(1)">' * 24 + b'<circle r="1"/>' + b"</g>" * 24 + b"</svg>",
        SVG.replace(b"0 0 100 100", b"0 0 1e-300 1e300") + b'<circle r="5"/></svg>',
        SVG + b"<style>" + b"a{" * 300 + b'</style><circle r="1" style="' + b"a:" * 200 + b'"/></svg>',
        SVG + b'<circle r="1" transform="rotate(' + b"1 " * 300 + b'"/></svg>',
        SVG.replace(b"100mm", b"9" * 20_000 + b"?", 1) + b"</svg>",
        SVG.replace(b"100mm", b"9" + b" " * 40_000 + b"?", 1) + b"</svg>",
        laughs(SVG + b"&a8;</svg>"),
        b"<svg>" * 300,
    ],
    "photo": [
        png(15800, 15800, 2**20, 8),
        png(15800, 15800, 8 * 2**20, 1),
        flat("WEBP", 15000, lossless=True, method=0),
        flat("JPEG2000", 3000),
        b"P6 15800 15800 255\n" + bytes(900),
    ],
    "npz": [
        npz(zipfile.ZIP_BZIP2, 2**26, 2**26),
        npz(zipfile.ZIP_LZMA, 2**24, 2**24),
        npz(zipfile.ZIP_DEFLATED, 2**20, 2**20, 20),
        npz(zipfile.ZIP_STORED, 10**12, 10),
    ],
    "json": [b"[" * 100_000, b'{"a":' * 20_000, b"9" * 100_000, b'{"t_s":[' + b"9" * 4000 + b"]}"],
    "faces-json": [b"[" * 100_000, b'{"points_px":' + b"[" * 900],
    "wish": [b"[" * 100_000, b'{"a":' * 50_000],
    "calibration-json": [b"[" * 100_000],
    "calibration-csv": [b"1,2,3\n" * 20_000],
    "settings": [
        b"a=" + b"[" * 100_000,
        b"[" + b"a." * 20_000 + b"a]",
        b"a=" + b"{a=" * 20_000,
        b"x" * 100_000 + b"=1",
    ],
    "assigned": [b"." * 50_000 + b"=1", b"order.kicks=" + b"[" * 50_000],
    "quantities": [b"page " + b"1" * 20_000 + b"x", b"length " + b"1" * 50_000 + b"e", b"page " + b"1 " * 20_000],
    "urdf": [
        laughs(b'<robot name="&a8;"/>'),
        b"<robot>" * 1000,
        # A ring of links beside the chain: whoever goes up from the only leaf goes round for ever.
        b'<robot name="r"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>'
        + b"".join(
            b'<joint name="%s%s" type="fixed"><parent link="%s"/><child link="%s"/></joint>' % (p, c, p, c)
            for p, c in (b"ad", b"bc", b"cb", b"bd")
            for p, c in [(bytes([p]), bytes([c]))]
        )
        + b"</robot>",
    ],
    "gcode": [
        b"G1 X1e30 Y99999999999999999999\n",
        b"M3 S90\nG2 " + b"X9 Y0 I500000 J500000\n" * 40,
        b"(" * 100_000,
        (b"(limner: page " + b"1" * 1900 + b")\n") * 50,
    ],
    "hpgl": [b"LB" * 50_000, b'CO"' * 30_000, b"PD" + b"9" * 1000 + b",1"],
    "joints-csv": [b't_s,"' + b"x" * 200_000],
    "photos-csv": [b'"' + b"x" * 200_000],
    "photos-txt": [b"x" * 3_000_000],
    "journal": [b"x\n" * 300_000],
    "grbl": [b"\xff" + b"\n" * 50_000],
    "ebb": [b"\xff" + b"\n" * 50_000],
    "rosbridge": [b"[" * 100_000],
    "addresses": [b"bridge rosbridge:ws://h" + b"/a" * 20_000 + b"!"],
}

PROGRAM = """
import contextlib, pickle, sys
from fuzz import harnesses
from limner.errors import LimnerError

cases = pickle.loads(sys.stdin.buffer.read())
reader = harnesses()[sys.argv[1]]
with open("/proc/self/statm") as file:
    held = int(file.read().split()[0]) * {page}
import resource, time
resource.setrlimit(resource.RLIMIT_AS, (held + {most}, held + {most}))
for data in cases:
    before = time.process_time()
    with contextlib.suppress(LimnerError):
        reader(data)
    print(time.process_time() - before, flush=True)
"""


LINUX = pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs Linux's way of telling memory")


def read_all(name, cases, program=PROGRAM):
    """A process that reads them; it cannot have more memory, and is ended when it takes far longer."""
    return subprocess.run(
        [sys.executable, "-c", program.format(page=resource.getpagesize(), most=BYTES), name],
        input=pickle.dumps(cases),
        capture_output=True,
        check=False,
        cwd=Path(__file__).parents[1],
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (60, 60)),
    )


@LINUX
@pytest.mark.parametrize("name", CASES)
def test_a_small_file_costs_little(name):
    done = read_all(name, CASES[name])
    seconds = [float(line) for line in done.stdout.split()]
    assert done.returncode == 0, (CASES[name][len(seconds)][:100], done.stderr.decode()[-400:])
    assert len(seconds) == len(CASES[name])
    assert max(seconds) < CPU_S, CASES[name][seconds.index(max(seconds))][:100]


@LINUX
def test_a_reader_that_takes_more_memory_is_noticed():
    hog = PROGRAM.replace("harnesses()[sys.argv[1]]", "lambda data: bytes(len(data) * 2**20)")
    assert read_all("svg", [b"x" * 10], hog).returncode == 0
    assert b"MemoryError" in read_all("svg", [b"x" * 10, b"x" * 1100], hog).stderr

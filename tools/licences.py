"""pyproject.toml in, docs/licences.md out: the licence of every package that limner or one of its extras brings.

Fails where a licence is not permissive and not named below with the reason why it is borne with.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from importlib.metadata import PackageNotFoundError, requires
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

OUT = Path("docs/licences.md")

PERMISSIVE = re.compile(
    r"MIT|BSD|Apache|ISC|Zlib|PSF|Python Software Foundation|ZPL|BSL-1\.0|MIT-CMU|0BSD|CC0|TCL|HPND|Unlicense|any-OSI"
)
NOT = re.compile(r"GPL|GNU|MPL|Mozilla|UNKNOWN|Commercial|Proprietary")

EXCEPTIONS = {
    "atheris": "Apache-2.0, which its metadata does not say; only in tests",
    "axe-playwright-python": "MIT, which its metadata does not say; holds axe-core (MPL-2.0); only in tests",
    "certifi": "MPL-2.0: a list of certificates, used unchanged by httpx in tests and the documentation's builder",
    "cmeel-qhull": "Qhull's own licence, permissive; its metadata does not say; extra robot",
    "hypothesis": "MPL-2.0; only in tests",
    "pathspec": "MPL-2.0; only mypy and mkdocs use it",
    "pnoise": "LGPL-2.1; the vpype extra brings it through vpype; limner does not load it",
    "pyphen": "LGPL or MPL at choice; the vpype extra brings it through vpype; limner does not load it",
    "urdf-parser-py": "BSD, which its metadata does not say; extra robot",
}
"""Package -> its licence, and why that is no hindrance."""

INSIDE = {
    "pillow-heif": "BSD-3-Clause; its wheels hold libheif (LGPL-3) and x265 (GPL-2); extra heic, so a choice",
    "opencv-python-headless": "Apache-2.0; its wheels hold FFmpeg (LGPL-2.1)",
    "shapely": "BSD-3-Clause; its wheels hold GEOS (LGPL-2.1); extra vpype",
}
"""Package -> what its wheels hold under another licence than its own."""


def closure(extra: str) -> set[str]:
    """Canonical names of all installed packages that ``limner[extra]`` needs; of limner alone where it is empty."""
    seen: set[str] = set()
    asked: set[str] = set()
    todo = [Requirement(f"limner[{extra}]" if extra else "limner")]
    while todo:
        wanted = todo.pop()
        if str(wanted) in asked:
            continue
        asked.add(str(wanted))
        for line in _requires(wanted.name):
            needed = Requirement(line)
            extras = wanted.extras or {""}
            if needed.marker is None or any(needed.marker.evaluate({"extra": name}) for name in extras):
                name = canonicalize_name(needed.name)
                seen.add(name)
                todo.append(Requirement(f"{name}[{','.join(sorted(needed.extras))}]" if needed.extras else name))
    return {name for name in seen if name != "limner" and _installed(name)}


def _requires(name: str) -> list[str]:
    try:
        return requires(name) or []
    except PackageNotFoundError:
        return []


def _installed(name: str) -> bool:
    try:
        requires(name)
    except PackageNotFoundError:
        return False
    return True


def extras() -> list[str]:
    """The extras that a user may ask for, as pyproject.toml names them."""
    named = tomllib.loads(Path("pyproject.toml").read_text())["project"]["optional-dependencies"]
    return ["", *sorted(set(named) - {"dev"}), "dev"]


def licences() -> dict[str, dict[str, Any]]:
    """What pip-licenses says of each installed package, by canonical name."""
    command = [sys.executable, "-m", "piplicenses", "--from=mixed", "--format=json", "--with-system"]
    rows = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return {canonicalize_name(row["Name"]): row for row in rows}


def main() -> int:
    """Write the table where it stands, or look whether it is as it should be (--check); 1 if a licence hinders."""
    known, shown, bad = licences(), set(), []
    lines = [
        "# Licences",
        "",
        "limner is under the MIT licence. What it and its extras bring (`make licences` writes this):",
        "",
    ]
    for extra in extras():
        new = sorted(closure(extra) - shown)
        shown |= set(new)
        lines += [f"## {f'limner[{extra}]' if extra else 'limner'}", "", "| package | licence | |", "|---|---|---|"]
        for name in new:
            licence = " ".join(known[name]["License"].split())
            note = EXCEPTIONS.get(name) or INSIDE.get(name, "")
            if name not in EXCEPTIONS and (NOT.search(licence) or not PERMISSIVE.search(licence)):
                bad.append(f"{name}: '{licence}' is not permissive, and not named as an exception")
            lines.append(f"| {name} | {licence} | {note} |")
        lines.append("")
    text = "\n".join(lines)
    if "--check" not in sys.argv:
        OUT.write_text(text)
    else:
        # Other versions of Python need a few packages less, so that rows may stand there that are not met here.
        there = OUT.read_text().splitlines()
        bad += [
            f"{OUT} lacks '{line}'; run: make licences" for line in lines if line.startswith("| ") and line not in there
        ]
    for line in bad:
        print(line, file=sys.stderr)
    return int(bool(bad))


if __name__ == "__main__":
    sys.exit(main())

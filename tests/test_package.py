"""What is shipped: the wheel alone draws a portrait, every licence is known, and nothing goes over the network."""

from __future__ import annotations

import json
import shutil
import socket
import subprocess
import sys
import tarfile
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

from limner import __version__
from limner.cli import main
from limner.cli.evaluate import astronaut

ROOT = Path(__file__).parent.parent
SHIPPED = ("src", "pyproject.toml", "README.md", "LICENSE", "CHANGELOG.md", "CITATION.cff", "MANIFEST.in")


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Folder with sdist and wheel, the wheel built from the sdist."""
    source = tmp_path_factory.mktemp("source")
    for name in SHIPPED:
        if (ROOT / name).is_dir():
            # Other processes write and rename files there while this one copies.
            shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
        else:
            shutil.copy(ROOT / name, source / name)
    subprocess.run(
        [sys.executable, "-m", "build", "--outdir", source / "dist", source], check=True, capture_output=True
    )
    return source / "dist"


def test_the_wheel_is_small_typed_and_has_its_models(built):
    (wheel,) = built.glob("*.whl")
    assert wheel.stat().st_size < 10e6
    names = set(zipfile.ZipFile(wheel).namelist())
    assert "limner/py.typed" in names
    tracked = {path.relative_to(ROOT / "src").as_posix() for path in (ROOT / "src/limner").rglob("*") if path.is_file()}
    missing = {name for name in tracked if "__pycache__" not in name} - names
    assert not missing, f"in the source, not in the wheel: {sorted(missing)}"


def test_the_sdist_tells_how_to_cite_and_what_changed(built):
    (sdist,) = built.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        names = {Path(name).name for name in archive.getnames()}
    assert {"README.md", "LICENSE", "CHANGELOG.md", "CITATION.cff", "pyproject.toml"} <= names


def test_the_wheel_alone_draws_a_portrait(built, tmp_path):
    (wheel,) = built.glob("*.whl")
    venv.create(tmp_path / "venv", with_pip=True)
    tools = tmp_path / "venv" / ("Scripts" if sys.platform == "win32" else "bin")
    install = [tools / "python", "-m", "pip", "--disable-pip-version-check", "--quiet", "install"]
    subprocess.run([*install, "--constraint", ROOT / "constraints.txt", wheel], check=True)
    drawn = subprocess.run(
        [tools / "limner", "draw", astronaut(), "-o", tmp_path / "out.svg", "--json"],
        check=True,
        capture_output=True,
        cwd=tmp_path,
        env={"PATH": str(tools)},
    )
    assert json.loads(drawn.stdout)["strokes"] > 20
    assert (tmp_path / "out.svg").read_bytes().startswith(b"<")


def test_licences_are_listed_and_permissive():
    ran = subprocess.run(
        [sys.executable, ROOT / "tools/licences.py", "--check"], cwd=ROOT, capture_output=True, text=True
    )
    assert (ran.returncode, ran.stderr) == (0, "")


def test_every_constraint_is_a_plain_pin():
    for line in (ROOT / "constraints.txt").read_text().splitlines():
        name, _, version = line.partition("==")
        assert name
        assert version
        assert not set(line) & set("/:@ ")


def test_drawing_opens_no_socket(monkeypatch, tmp_path):
    def refused(*_):
        raise AssertionError("a socket was opened")

    for name in ("connect", "connect_ex", "bind", "sendto"):
        monkeypatch.setattr(socket.socket, name, refused)
    monkeypatch.setattr(socket, "getaddrinfo", refused)
    outs = [str(tmp_path / f"a.{kind}") for kind in ("svg", "png", "gcode", "hpgl", "json", "npz")]
    words = [word for out in outs for word in ("-o", out)]
    monkeypatch.setattr(sys, "argv", ["limner", "draw", str(astronaut()), *words, "--style", "auto", "--tone", "light"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code in (0, None)
    assert all(Path(out).stat().st_size for out in outs)


def test_the_citation_has_the_version_and_licence_of_the_package():
    lines = (ROOT / "CITATION.cff").read_text().splitlines()
    assert f"version: {__version__}" in lines
    assert f"license: {tomllib.loads((ROOT / 'pyproject.toml').read_text())['project']['license']}" in lines

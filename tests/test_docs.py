"""The documentation: what it shows runs, what is generated is up to date, the site builds without the network."""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from drawings import of
from limner.cli.evaluate import astronaut
from limner.targets.svg import to_svg

ROOT = Path(__file__).parents[1]
PAGES = sorted(path for path in (ROOT / "docs").rglob("*.md") if "```" in path.read_text())
EXAMPLES = sorted((ROOT / "examples").glob("[0-9]*.py"))
WITHOUT_A_RUN = {"text", "json"}
"""Languages of blocks that show and are not run."""
STRICT = {"PYTHONWARNINGS": "error"}


def blocks(path):
    """Language and content of each block of code, in order."""
    return re.findall(r"^```(\w*)[^\n]*\n(.*?)^```", path.read_text(), re.M | re.S)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a photo, a drawing and a folder of photos in it, to be in."""
    shutil.copy(astronaut(), tmp_path / "me.jpg")
    (tmp_path / "me.svg").write_bytes(to_svg(of([[20, 20], [60, 90]])))
    (tmp_path / "photos").mkdir()
    shutil.copy(astronaut(), tmp_path / "photos" / "one.jpg")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_there_is_something_to_test():
    assert len(PAGES) > 5
    assert len(EXAMPLES) > 5


@pytest.mark.parametrize("page", PAGES, ids=lambda path: str(path.relative_to(ROOT / "docs")))
def test_every_block_runs(folder, page):
    for language, code in blocks(page):
        if language == "sh":
            for line in filter(None, (line.partition(" #")[0].strip() for line in code.splitlines())):
                assert line.startswith("limner "), f"{page.name}: only limner runs here: {line}"
                subprocess.run(
                    [sys.executable, "-m", *shlex.split(line)],
                    check=True,
                    env=os.environ | STRICT,
                    stdin=subprocess.DEVNULL,
                    capture_output=True,
                )
        elif language == "python":
            with contextlib.redirect_stdout(None):
                exec(compile(code, page.name, "exec"), {})
        else:
            assert language in WITHOUT_A_RUN, f"{page.name}: a block in '{language}' is not run"


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_every_example_runs_alone_and_is_short(folder, example):
    assert len(example.read_text().splitlines()) < 80
    env = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    subprocess.run([sys.executable, example, "me.jpg"], check=True, env=env, capture_output=True)


def test_every_example_is_listed():
    listed = re.findall(r"\((\d\d_\w+\.py)\)", (ROOT / "examples" / "README.md").read_text())
    assert listed == [path.name for path in EXAMPLES]


def test_the_reference_is_up_to_date():
    ran = subprocess.run(
        [sys.executable, ROOT / "tools/reference.py", "--check"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT / "src")},
    )
    assert (ran.returncode, ran.stderr) == (0, "")


def test_the_page_on_the_layout_names_what_there_is():
    page, source = (ROOT / "docs/contributing.md").read_text(), ROOT / "src" / "limner"
    parts = {path.stem for path in source.iterdir() if not path.name.startswith("_") and path.suffix in ("", ".py")}
    assert {part for part in parts if not re.search(rf"\b{part}\b", page)} == set()
    for word in re.findall(r"`([\w/]+(?:/|\.py)\w*)`", page):
        places = [ROOT, source, *(path for path in source.rglob("*") if path.is_dir())]
        assert any((place / word).exists() for place in places), word


def test_the_site_builds_and_asks_no_other_host(tmp_path):
    pytest.importorskip("mkdocs", reason="mkdocs is not installed: pip install 'limner[docs]'")
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--site-dir", tmp_path / "site"]
    env = os.environ | {
        "NO_MKDOCS_2_WARNING": "1",
        "http_proxy": "http://127.0.0.1:9",
        "https_proxy": "http://127.0.0.1:9",
    }
    subprocess.run(command, check=True, cwd=ROOT, env=env, capture_output=True)
    pages = list((tmp_path / "site").rglob("*.html"))
    assert len(pages) > 10
    for page in pages:
        asked = re.findall(r"<(?:script|img|iframe|source)[^>]* src=[\"']?(https?:[^\"' >]+)", page.read_text())
        asked += re.findall(
            r"<link[^>]* rel=[\"']?(?:stylesheet|preconnect)[^>]* href=[\"']?(https?:[^\"' >]+)", page.read_text()
        )
        assert not asked, page.name

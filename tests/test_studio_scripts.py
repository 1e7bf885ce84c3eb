"""The page's own tests, run by node, and what holds for all its files."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "src" / "limner" / "studio" / "page"
SCRIPTS = sorted((PAGE / "js").rglob("*.js"))


def test_the_scripts_pass_their_own_tests():
    node = shutil.which("node") or pytest.skip("needs node: apt-get install nodejs")
    tests = sorted(str(path) for path in (ROOT / "tests" / "js").glob("*.test.js"))
    done = subprocess.run([node, "--test", *tests], capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stdout[-4000:]


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.name)
def test_every_script_says_what_it_is_and_is_small(path):
    lines = path.read_text().splitlines()
    assert lines[0].startswith("// ")
    assert lines[0].endswith(".")
    assert len(lines) <= 330


def test_imports_lead_to_files_and_none_is_left_over():
    used = {PAGE / "js" / name for name in ("main.js", "booth.js", "operator.js")}
    for path in SCRIPTS:
        for name in re.findall(r"""(?:from|import)\s*\(?\s*["'](\.[^"']+)["']""", path.read_text()):
            target = (path.parent / name).resolve()
            assert target.exists() or "built" in name, f"{path.name} imports {name}"
            used.add(target)
    assert {path for path in SCRIPTS if path not in used} == set()


@pytest.mark.parametrize("path", sorted(PAGE.glob("*.html")), ids=lambda path: path.name)
def test_pages_hold_no_script_or_style_of_their_own_and_name_no_other_host(path):
    text = path.read_text()
    assert not re.search(r"<style|style=|\son\w+=|<script(?![^>]*\ssrc=)", text)
    assert not re.search(r"(?:https?:)?//[a-z]", text)

"""A browser for tests: Debian's Chromium, its camera fed with a portrait, everything it complains about collected."""

from __future__ import annotations

import contextlib
import io
import shutil
import time
from importlib import resources

import pytest
from PIL import Image

from limner.cli.evaluate import astronaut

FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--disable-gpu-watchdog",
    "--use-fake-ui-for-media-stream",
    "--use-fake-device-for-media-stream",
]
PATIENCE_S = 240.0
"""A busy machine is no failure."""
STILL = """() => document.getAnimations().every(({ playState, effect }) =>
    playState !== 'running' || effect.getComputedTiming().iterations === Infinity)"""
"""Nothing fades or slides: half faded a text has another contrast."""

RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]


def camera_film(path):
    """What the fake camera sees: the astronaut's head, as a film of JPEGs."""
    out = io.BytesIO()
    Image.open(astronaut()).convert("RGB").crop((0, 0, 512, 384)).resize((640, 480)).save(out, "JPEG", quality=92)
    path.write_bytes(out.getvalue() * 30)
    return path


@contextlib.contextmanager
def chromium(film=None, *flags):
    """Chromium; the test skips where there is none."""
    where = shutil.which("chromium") or pytest.skip("needs Chromium: apt-get install chromium")
    from playwright.sync_api import sync_playwright

    more = [f"--use-file-for-fake-video-capture={film}"] if film else []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=where, args=[*FLAGS, *more, *flags])
        try:
            yield browser
        finally:
            browser.close()


@contextlib.contextmanager
def another(browser, *flags, without=()):
    """A second Chromium beside one that runs, with more flags and without some of the usual."""
    where, kept = shutil.which("chromium"), [flag for flag in FLAGS if flag not in without]
    second = browser.browser_type.launch(executable_path=where, args=[*kept, *flags])
    try:
        yield second
    finally:
        second.close()


class Visit:
    """A person's tab.

    Attributes:
        page: Playwright's.
        complaints: errors of the console, of scripts, requests that failed or went to another host.
        expected: words of complaints that belong to what is tried.
    """

    def __init__(self, browser, url, *, context=None, **how):
        self.context = context or browser.new_context(viewport={"width": 1280, "height": 800}, **how)
        self.page = self.context.new_page()
        self.page.set_default_timeout(1000 * PATIENCE_S)
        self.complaints, self.expected = [], ()
        host = "/".join(url.split("/")[:3])
        self.page.on("console", lambda said: self._hear(said.type in ("error", "warning"), f"console: {said.text}"))
        self.page.on("pageerror", lambda error: self._hear(True, f"script: {error}"))
        self.page.on(
            "request", lambda asked: self._hear(not asked.url.startswith((host, "blob:", "ws" + host[4:])), asked.url)
        )
        self.page.goto(url)
        self.until("() => Boolean(globalThis.limnerApp)")

    def _hear(self, bad, text):
        if bad and not any(words in text for words in self.expected):
            self.complaints.append(text)

    def until(self, script):
        """Wait until an expression is true (the page's own rules forbid Playwright's way of waiting for one)."""
        return self.wait(lambda: self.page.evaluate(script), script)

    def wait(self, right, what="what was waited for"):
        """Wait until something is true."""
        ends = time.monotonic() + PATIENCE_S
        while not (value := right()):
            assert time.monotonic() < ends, f"never: {what}"
            self.page.wait_for_timeout(50)
        return value

    def go(self, screen):
        """To a screen by its link; it is shown now."""
        self.page.get_by_role("navigation", name="Steps").get_by_role("link", name=screen).click()
        self.until(f"() => limnerApp.state.screen === '{screen.lower()}'")

    def choose_photo(self, data, name="me.jpg"):
        """Give it a photo as a file."""
        files = {"name": name, "mimeType": "image/jpeg", "buffer": data}
        self.page.locator("input[type=file]").set_input_files(files)

    def violations(self):
        """What axe-core finds against WCAG 2.2 AA and its best practices."""
        code = resources.files("axe_playwright_python").joinpath("axe.min.js").read_text()
        self.page.evaluate(code)
        self.until(STILL)
        found = self.page.evaluate("rules => axe.run(document, {runOnly: rules})", RULES)
        assert found["passes"], "axe looked at nothing"
        return [f"{v['id']}: {v['help']} {[n['target'] for n in v['nodes']]}" for v in found["violations"]]

"""A studio is started and used in Chromium; its screens as the documentation shows them come out, and its example.

Run from the checkout, after a change of the page or of the portrait: PYTHONPATH=tests .venv/bin/python
tools/studio_pictures.py (make studio-pictures does). The photo is that of the astronaut.
"""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
from PIL import Image

import browsers
import studios
from limner.cli.evaluate import astronaut
from limner.pipeline import Session, Settings
from limner.vision.photo import load_photo

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "images" / "studio"
SPECIMEN = ROOT / "src" / "limner" / "studio" / "page" / "img" / "specimen.json"
SHARE = 0.75
COLOURS = 96
SETTLED = "() => limnerApp.state.preview?.final && limnerApp.state.preview.rev === limnerApp.state.revision"
CANDIDATES = "() => limnerApp.state.candidates.length && Array.from(limnerApp.state.candidates).every(Boolean)"
PLANNED = "() => limnerApp.state.plan?.times?.length"
SHADED = {"select.points": 1000, "tone.level": "light"}
SPACE = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")


def specimen():
    """The example of the first page: lines from the upper left corner in tenths of a millimetre."""
    drawing = Session(load_photo(astronaut())).draw(Settings()).drawing
    height = drawing.page.height_mm
    return [np.rint(10 * (line * [1, -1] + [0, height])).astype(int).ravel().tolist() for line in drawing.lines_mm]


def write_specimen():
    """The example, a line of the file for each of the drawing."""
    lines = ",\n".join(json.dumps(line, separators=(",", ":")) for line in specimen())
    SPECIMEN.write_text(f"[{lines}]\n")


def photo():
    """The astronaut, as JPEG."""
    out = io.BytesIO()
    Image.open(astronaut()).convert("RGB").save(out, "JPEG", quality=95)
    return out.getvalue()


def keep(visit, name, share=SHARE):
    """What the page shows now, in few colours unless it is a JPEG."""
    visit.until(browsers.STILL)
    shown = Image.open(io.BytesIO(visit.page.screenshot())).convert("RGB")
    small = shown.resize([round(share * side) for side in shown.size], Image.Resampling.LANCZOS)
    if name.endswith("jpg"):
        small.save(PICTURES / name, quality=82, optimize=True)
    else:
        small.quantize(COLOURS, dither=Image.Dither.NONE).save(PICTURES / name, optimize=True)


def begun(browser, server, **how):
    """A tab in which the astronaut is drawn."""
    visit = browsers.Visit(browser, server.url, **how)
    visit.choose_photo(photo())
    visit.page.locator(".card .facts").first.wait_for()
    return visit


def first_pages(browser, server):
    """From the example to the candidates."""
    visit = browsers.Visit(browser, server.url)
    visit.page.wait_for_timeout(9000)
    keep(visit, "photo.png")
    visit.choose_photo(photo())
    visit.until(CANDIDATES)
    keep(visit, "choose.png")
    visit.go("Face")
    row = visit.page.locator(".picks button", has_text="Jaw, by gradient")
    row.wait_for()
    visit.until("() => limnerEditor.view && limnerEditor.image.complete")
    row.hover()
    keep(visit, "face.jpg")
    visit.context.close()


def drawn(browser, server):
    """Adjusted, watched and sent."""
    visit = begun(browser, server)
    visit.page.evaluate("settings => limnerApp.setSettings(settings)", SHADED)
    visit.go("Adjust")
    visit.until(SETTLED)
    keep(visit, "adjust.png")
    visit.go("Watch")
    visit.until(PLANNED)
    watch(visit)
    keep(visit, "watch.png")
    visit.go("Send")
    visit.page.get_by_role("button", name="A simulated plotter, fast").click()
    visit.until("() => document.querySelectorAll('.panel input[type=checkbox]').length > 1")
    for box in visit.page.get_by_role("checkbox").all():
        box.check()
    visit.page.get_by_role("button", name="Start drawing").click()
    visit.until("() => limnerApp.state.job.share > 0.5")
    keep(visit, "send.png")
    visit.context.close()


def watch(visit, share="0.8"):
    """The replay stands at a share of its time, all that it can show shown."""
    for name in ("Moves of the lifted pen", "Colour by order"):
        visit.page.get_by_label(name).check()
    visit.page.get_by_role("slider", name="Time").fill(share)


def arms(browser, server):
    """An arm from above, another in 3-D."""
    with browsers.another(browser, *SPACE, without=["--disable-gpu"]) as other:
        visit = begun(other, server)
        visit.page.evaluate("settings => limnerApp.setSettings(settings)", SHADED)
        visit.go("Watch")
        for robot, view, name in (("dumbo", "From above", "above.png"), ("ur5e", "3-D", "arm.jpg")):
            visit.page.locator("#drawer").select_option(f"robot:{robot}")
            visit.until("() => limnerApp.state.plan?.joints?.length")
            visit.page.get_by_role("button", name=view).click()
            if view == "3-D":
                visit.page.get_by_text("Drag to turn").wait_for()
            watch(visit)
            keep(visit, name)
        visit.context.close()


def looks(browser, server):
    """In the dark, and on a phone."""
    phone = {"viewport": {"width": 390, "height": 760}}
    for name, share, how in (("dark.png", SHARE, {"color_scheme": "dark"}), ("phone.png", 1, phone)):
        context = browser.new_context(**{"viewport": {"width": 1280, "height": 800}, **how})
        visit = begun(browser, server, context=context)
        visit.page.evaluate("settings => limnerApp.setSettings(settings)", SHADED)
        visit.go("Adjust")
        visit.until(SETTLED)
        keep(visit, name, share)
        context.close()


def booth(browser):
    """A guest's choice, and the operator's page with two who wait."""
    with studios.serving("--booth") as server:
        guest = browsers.Visit(browser, server.url)
        guest.page.get_by_role("button", name="Touch to be drawn").click()
        guest.page.locator(".three button").nth(2).wait_for()
        keep(guest, "booth.png")
        for name in ("Ada", "Ben"):
            wish = {"photo": guest.page.evaluate("() => limnerApp.guest.photo"), "settings": {"page.size": "a6"}}
            script = """async ([wish, name]) => {
                const ask = (path, body) => fetch(path, { method: 'POST', body: JSON.stringify(body) });
                const { drawing } = await (await ask('api/drawing', wish)).json();
                await ask('api/queue', { drawing, name });
            }"""
            guest.page.evaluate(script, [wish, name])
        operator = browsers.Visit(browser, server.said["operator_url"])
        operator.page.get_by_text("2 in the queue").wait_for()
        operator.page.wait_for_timeout(2000)
        keep(operator, "operator.png")


def main():
    """All of them, where the documentation looks for them."""
    write_specimen()
    film = Path("build") / "camera.mjpeg"
    film.parent.mkdir(exist_ok=True)
    with browsers.chromium(browsers.camera_film(film)) as browser:
        with studios.serving() as server:
            first_pages(browser, server)
            drawn(browser, server)
            arms(browser, server)
            looks(browser, server)
        booth(browser)


if __name__ == "__main__":
    main()

"""A studio is started and used in Chromium; how long a person waits for what comes out as a table.

Run from the checkout: PYTHONPATH=tests .venv/bin/python tools/studio_bench.py (make bench-studio does).
"""

from __future__ import annotations

import io
import statistics
import time

from PIL import Image

import browsers
import studios
from limner.cli.evaluate import astronaut

MOVES = 30
PHOTOS = 5
STROKES, POINTS = 600, 20_000
REPLAY_S = 8.0

# The slider is moved: time until the frame after the new drawing is on the sheet, and how long that was computed [ms].
MOVE = """value => new Promise(done => {
    const slider = document.getElementById('slider-detail');
    const begun = performance.now();
    slider.value = value;
    slider.dispatchEvent(new Event('input'));
    const rev = limnerApp.state.revision;
    const stop = limnerApp.store.watch(['preview'], ({ preview }) => {
        if (preview.rev >= rev) requestAnimationFrame(() => {
            stop();
            done([performance.now() - begun, 1000 * preview.report.compute_s]);
        });
    });
})"""

# A drawing of so many points, as long as a portrait, takes the place of the one on the desk.
MANY = """([strokes, points]) => {
    const offsets = Uint32Array.from({ length: strokes + 1 }, (_, i) => Math.round(i * points / strokes));
    const places = new Int16Array(2 * points);
    for (let s = 0, i = 0; s < strokes; s += 1) {
        let [x, y, turn] = [2000 + 10000 * ((s * 0.618) % 1), 2000 + 16000 * ((s * 0.414) % 1), s];
        for (; i < offsets[s + 1]; i += 1) {
            turn += 0.35 * Math.sin(i * 0.13);
            [x, y] = [x + 45 * Math.cos(turn), y + 45 * Math.sin(turn)];
            places.set([x, y], 2 * i);
        }
    }
    const preview = { ...limnerApp.state.preview, lines: { offsets, points: places, unit: 0.01 } };
    limnerApp.set({ preview, plan: null });
}"""


def photo():
    """The astronaut in 640x800, as JPEG."""
    out = io.BytesIO()
    Image.open(astronaut()).convert("RGB").crop((10, 0, 420, 512)).resize((640, 800)).save(out, "JPEG", quality=90)
    return out.getvalue()


def first_drawings(visit, data):
    """Seconds from a photo given to its first drawing on the page, some times."""
    for _ in range(PHOTOS):
        visit.page.goto(visit.page.url.split("#")[0])
        visit.until("() => Boolean(globalThis.limnerApp)")
        visit.page.evaluate("() => { limnerApp.set({ photo: null, preview: null }); location.hash = 'photo'; }")
        visit.page.wait_for_timeout(300)
        begun = time.perf_counter()
        visit.choose_photo(data)
        visit.until("() => Boolean(limnerApp.state.preview)")
        yield time.perf_counter() - begun


def slider_moves(visit):
    """Milliseconds from a move of a slider to the new drawing, and in computing it, each after the one before it."""
    visit.go("Adjust")
    for i in range(MOVES):
        visit.until("() => limnerApp.state.preview?.final")
        yield visit.page.evaluate(MOVE, 0.2 + 0.6 * ((i * 0.618) % 1))


def frames_per_second(visit):
    """Of the replay of a drawing of many points, drawn within some seconds."""
    visit.until("() => limnerApp.state.preview?.final")
    visit.go("Watch")
    visit.until("() => limnerApp.state.plan?.times?.length")
    visit.page.evaluate(MANY, [STROKES, POINTS])
    visit.page.evaluate(f"() => {{ limnerPlayer.pause(); limnerPlayer.speed = limnerPlayer.duration / {REPLAY_S}; }}")
    visit.page.evaluate("() => { limnerPlayer.seek(0); limnerPlayer.play(); }")
    visit.until("() => limnerPlayer.time >= limnerPlayer.duration")
    return visit.page.evaluate("() => limnerPlayer.framesPerSecond")


def main():
    """Print the table."""
    begun = time.perf_counter()
    with studios.serving() as server:
        with studios.enter(server) as client:
            client.get("/api/options")
            answered = time.perf_counter() - begun
        print_table(server, answered)


def print_table(server, answered):
    """Measure the page of a server that answered after so many seconds."""
    with browsers.chromium() as browser:
        visit = browsers.Visit(browser, server.url)
        drawn = list(first_drawings(visit, photo()))
        moves = sorted(slider_moves(visit))
        waits, computing = zip(*moves, strict=True)
        rows = [
            ("server started to its first answer", f"{answered:.1f} s", "1.5 s"),
            ("photo given to first drawing, median", f"{statistics.median(drawn):.2f} s", "2 s"),
            ("slider to new drawing, 640x800, median", f"{statistics.median(waits):.0f} ms", "300 ms"),
            ("the same, 95 % of them", f"{waits[int(0.95 * len(waits))]:.0f} ms", "450 ms"),
            ("of the median its stages, without likeness and encoding", f"{statistics.median(computing):.0f} ms", ""),
            (f"replay of {POINTS} points", f"{frames_per_second(visit):.0f} frames/s", "50 frames/s"),
        ]
    print("| the studio in Chromium | measured | asked for |\n|---|---|---|")
    print("\n".join(f"| {' | '.join(row)} |" for row in rows))


if __name__ == "__main__":
    main()

"""The studio's page in a real browser: what a person does with mouse, keys and camera, and what it then shows."""

from __future__ import annotations

import base64
import contextlib
import io
import subprocess
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageOps

import browsers
import studios

pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[1]
BUILT = ROOT / "src" / "limner" / "studio" / "page" / "built" / "arm3d.js"
SOURCE = ROOT / "src" / "limner" / "studio" / "arm3d" / "arm3d.js"
SETTLED = "() => limnerApp.state.preview?.final && limnerApp.state.preview.rev === limnerApp.state.revision"
"""The drawing is that of the latest wish."""
SCREENS = ("Photo", "Face", "Choose", "Adjust", "Watch", "Send")


@pytest.fixture(scope="module")
def server():
    with studios.serving() as server:
        yield server


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    film = browsers.camera_film(tmp_path_factory.mktemp("camera") / "face.mjpeg")
    with browsers.chromium(film) as browser:
        yield browser


@pytest.fixture
def visit(server, browser):
    visit = browsers.Visit(browser, server.url)
    yield visit
    visit.context.close()
    assert visit.complaints == []


@pytest.fixture
def drawn(visit):
    """A tab in which a photo has been drawn."""
    visit.choose_photo(studios.face_jpeg())
    visit.page.locator(".card .facts").first.wait_for()
    return visit


def figure(visit, name):
    """A figure under the sheet."""
    return visit.page.locator(".figures div", has_text=name).locator("dd").inner_text()


def ink(visit, selector=".stage .sheet canvas:nth-child(2)"):
    """How many pixels of the sheet have ink."""
    script = """selector => {
        const canvas = document.querySelector(selector);
        const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
        let count = 0;
        for (let i = 3; i < data.length; i += 4) count += data[i] > 40;
        return count;
    }"""
    return visit.page.evaluate(script, selector)


def red_ink(visit, selector=".stage .sheet canvas:nth-child(2)"):
    """How many pixels of the sheet are of the red pencil."""
    script = """selector => {
        const canvas = document.querySelector(selector);
        const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
        let count = 0;
        for (let i = 0; i < data.length; i += 4) count += data[i + 3] > 99 && data[i] > data[i + 1] + 40;
        return count;
    }"""
    return visit.page.evaluate(script, selector)


def inked(visit, pixels, *selector):
    """Wait until the sheet has more ink than that."""
    visit.wait(lambda: ink(visit, *selector) > pixels)


def test_from_the_camera_to_a_finished_job(visit):
    page = visit.page
    page.get_by_role("button", name="Use the camera").click()
    page.get_by_role("button", name="Take the photo").click()
    page.get_by_role("button", name="Take another").click()
    page.get_by_role("button", name="Take the photo").click()
    page.get_by_role("button", name="Use this photo").click()
    page.get_by_role("heading", name="Which one is it?").wait_for()
    page.locator(".card .facts").nth(1).wait_for()
    second = page.get_by_role("button", pressed=False).filter(has=page.locator(".facts")).first
    name = second.locator(".name").inner_text().split("\n")[0]
    second.click()
    page.get_by_role("button", name=name, pressed=True).wait_for()
    page.get_by_role("link", name="Go on with this one").click()
    page.get_by_role("button", name=name, exact=True, pressed=True).wait_for()
    visit.until(SETTLED)
    strokes = int(figure(visit, "Strokes"))
    assert strokes > 10
    start_on(visit, "sim:100")
    page.get_by_role("heading", name="Done").wait_for()
    job = page.evaluate("() => limnerApp.state.job")
    assert (job["mine"], job["share"], job["stroke"], job["strokes"]) == (True, 1, strokes, strokes)
    inked(visit, 1000)
    page.get_by_role("button", name="Put away").click()
    visit.until("() => limnerApp.state.job.state === 'idle'")


def test_a_drawing_of_several_pens_is_shown_in_their_colours(drawn):
    page = drawn.page
    drawn.go("Adjust")
    page.locator("[data-style=cartoon]").click()
    drawn.until("() => limnerApp.value('style') === 'cartoon'")
    drawn.until(SETTLED)
    inks = drawn.until("() => limnerApp.state.preview.page.inks")
    assert len(set(inks)) == len(inks) > 1
    script = """inks => {
        const canvas = document.querySelector('.stage .sheet canvas:nth-child(2)');
        const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
        const rgb = inks.map(ink => [1, 3, 5].map(i => parseInt(ink.slice(i, i + 2), 16)));
        const near = (i, colour) => data[i + 3] > 250 && colour.every((value, k) => Math.abs(data[i + k] - value) < 8);
        const pixels = [...Array(data.length / 4).keys()];
        return rgb.map(colour => pixels.filter(i => near(4 * i, colour)).length);
    }"""
    drawn.wait(lambda: min(page.evaluate(script, inks)) > 5)


def test_a_landmark_is_dragged_nudged_and_brought_back(drawn):
    page = drawn.page
    drawn.go("Face")
    editor = page.get_by_role("application")
    drawn.until(SETTLED)
    before = drawn.until("() => limnerApp.landmarks?.slice()")
    undo, redo = page.get_by_role("button", name="Undo"), page.get_by_role("button", name="Redo")
    assert undo.is_disabled()
    # Where the tip of the nose is shown.
    x, y = drawn.until("() => limnerEditor.view && limnerEditor.screenOf(30)")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 24, y + 10, steps=4)
    page.mouse.up()
    after = page.evaluate("() => limnerApp.landmarks")
    assert after[30][0] > before[30][0] + 1
    assert after[:30] + after[31:] == before[:30] + before[31:]
    page.keyboard.press("Shift+ArrowLeft")
    nudged = page.evaluate("() => limnerApp.landmarks")
    assert nudged[30] == pytest.approx([after[30][0] - 10, after[30][1]])
    page.keyboard.press("Control+z")
    assert page.evaluate("() => limnerApp.landmarks[30]") == pytest.approx(after[30])
    undo.click()
    assert page.evaluate("() => limnerApp.landmarks") == before
    assert undo.is_disabled()
    redo.click()
    assert page.evaluate("() => limnerApp.landmarks[30]") == pytest.approx(after[30])
    page.get_by_role("button", name="Reset all").click()
    assert page.evaluate("() => limnerApp.landmarks") == before
    editor.focus()
    page.keyboard.press(".")
    assert " of 68: " in page.get_by_role("status").filter(has_text="of 68").inner_text()


def test_a_correction_is_compared_and_taken(drawn):
    drawn.go("Face")
    corrections = drawn.page.locator(".picks button:enabled")
    corrections.first.wait_for()
    drawn.until(SETTLED)
    before = drawn.page.evaluate("() => limnerApp.landmarks")
    # A button under somebody's finger stays the same one when more corrections come in.
    same = """() => {
        const row = document.querySelector('.picks li');
        limnerApp.set({ refinements: [...limnerApp.state.refinements] });
        return row === document.querySelector('.picks li');
    }"""
    assert drawn.page.evaluate(same)
    corrections.filter(has_text="As they were found").click()
    assert drawn.page.evaluate("() => limnerApp.landmarks") != before
    drawn.page.get_by_role("button", name="Undo").click()
    assert drawn.page.evaluate("() => limnerApp.landmarks") == before


def test_sliders_budget_and_settings_change_the_drawing(drawn):
    page = drawn.page
    drawn.go("Adjust")
    drawn.until("() => limnerApp.state.preview?.final")
    points = int(figure(drawn, "Points"))
    page.get_by_role("button", name="Points", exact=True).click()
    page.get_by_role("slider", name="At most").fill("0.15")
    drawn.until(f"() => limnerApp.state.preview.final && limnerApp.state.preview.report.points < {points}")
    assert int(figure(drawn, "Points")) < points
    page.get_by_role("button", name="Everything").click()
    page.get_by_role("slider", name="Shading").fill("1")
    drawn.until(f"() => limnerApp.state.preview.report.points > {1.5 * points}")
    page.get_by_text("Every setting").click()
    page.get_by_role("searchbox", name="Search all settings").fill("hair apart")
    field = page.get_by_role("textbox", name="hair apart")
    field.fill("7")
    field.press("Enter")
    assert page.locator(".wrong:not(:empty)").inner_text() == "at most 1"
    field.fill("0.2")
    field.press("Enter")
    drawn.until("() => limnerApp.state.settings['portrait.hair_apart'] === 0.2")
    page.get_by_role("button", name="As it was").click()
    drawn.until(f"() => limnerApp.state.preview.final && limnerApp.state.preview.report.points === {points}")


def test_ink_appears_as_the_replay_goes_on_and_goes_when_it_goes_back(drawn):
    page = drawn.page
    drawn.until("() => limnerApp.state.preview?.final")
    drawn.go("Watch")
    # At once: it plays by itself, and would come to its end.
    page.get_by_role("button", name="Pause").click()
    # Until the machine's own times are there the replay follows an estimate, and 0.3 of it is another place.
    drawn.until("() => limnerApp.state.plan?.times?.length")
    time = page.get_by_role("slider", name="Time")
    seen = []
    for share in ("0", "0.3", "0.7", "1"):
        time.fill(share)
        seen.append(ink(drawn))
    assert seen[0] < 60 < seen[1] < seen[2] < seen[3]
    time.fill("0.3")
    assert ink(drawn) == seen[1]
    page.get_by_label("Moves of the lifted pen").check()
    assert ink(drawn) > seen[1]
    time.fill("1")
    page.get_by_role("button", name="64").click()
    page.get_by_role("button", name="Play").click()
    drawn.until("() => limnerPlayer.time >= limnerPlayer.duration")


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"no picture at all", "no picture"),
        (studios.face_jpeg()[:300], ""),
        (studios.moving(), "animation"),
        (b"", ""),
    ],
    ids=["text", "cut off", "moving", "empty"],
)
def test_a_bad_photo_is_refused_in_words_and_another_can_be_given(visit, data, says):
    visit.expected = ("status of 400",)
    visit.choose_photo(data)
    note = visit.page.get_by_role("alert")
    assert says in note.inner_text()
    assert len(note.inner_text()) > 15
    visit.choose_photo(studios.face_jpeg())
    visit.page.locator(".card .facts").first.wait_for()


def test_without_a_face_the_landmarks_are_placed_by_hand(visit):
    page = visit.page
    visit.choose_photo(studios.picture(size=(400, 500)))
    page.get_by_role("button", name="Place the landmarks by hand").click()
    visit.until("() => limnerEditor?.points.length === 68")
    x, y = visit.until("() => limnerEditor.view && limnerEditor.screenOf(8)")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y + 30, steps=3)
    page.mouse.up()
    page.get_by_role("button", name="That is the face").click()
    # An even grey has no lines of its own: only the splines through the landmarks can be drawn.
    page.locator(".card", has_text="Splines").locator(".facts").wait_for()


@pytest.mark.parametrize("how", ["drop", "paste"])
def test_a_photo_is_dropped_or_pasted_anywhere(visit, how):
    script = """([kind, text]) => {
        const bytes = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
        const data = new DataTransfer();
        data.items.add(new File([bytes], 'me.jpg', { type: 'image/jpeg' }));
        const more = { bubbles: true, dataTransfer: data, clipboardData: data };
        document.body.dispatchEvent(kind === 'drop' ? new DragEvent(kind, more) : new ClipboardEvent(kind, more));
    }"""
    visit.page.evaluate(script, [how, base64.b64encode(studios.face_jpeg()).decode()])
    visit.page.get_by_role("heading", name="Which one is it?").wait_for()


def test_what_cannot_be_reached_is_red(drawn):
    drawn.until("() => limnerApp.state.preview?.final")
    drawn.go("Watch")
    drawn.page.get_by_role("button", name="Pause").click()
    drawn.until("() => limnerApp.state.plan?.times?.length")
    drawn.page.get_by_role("slider", name="Time").fill("1")
    assert red_ink(drawn) == 0
    drawn.page.evaluate("() => limnerApp.set({ plan: { unreachable: [0, 1, 2, 3, 4] }, planError: 'out of reach' })")
    drawn.page.get_by_text("What is red cannot be reached.").wait_for()
    assert red_ink(drawn) > 100
    assert drawn.violations() == []


def test_candidates_still_come_when_one_is_chosen_early_and_when_the_screen_is_left(visit):
    # Those that take seconds come after it.
    last_of_the_quick = "() => limnerApp.state.candidates.some(({ name }) => name === 'landmarks-average')"
    visit.choose_photo(studios.face_jpeg())
    visit.page.locator(".card .facts").first.click()
    visit.until(last_of_the_quick)
    visit.page.evaluate("() => limnerApp.setSettings({ 'page.size': 'a6' })")
    visit.until("() => limnerApp.state.candidates.some(Boolean)")
    visit.go("Face")
    visit.go("Choose")
    visit.until(last_of_the_quick)


def test_who_comes_back_to_his_photo_sees_it_and_goes_on(drawn):
    page = drawn.page
    drawn.go("Photo")
    page.get_by_role("heading", name="Your photo").wait_for()
    page.get_by_role("img", name="Your photo").wait_for()
    assert drawn.violations() == []
    # A camera that fails takes nothing away.
    page.evaluate("() => limnerApp.set({ trouble: { text: 'no camera was found' } })")
    page.get_by_role("heading", name="That did not work").wait_for()
    assert page.get_by_role("img", name="Your photo").is_visible()
    page.evaluate("() => limnerApp.set({ trouble: null })")
    page.get_by_role("link", name="Go on with this one").click()
    page.get_by_role("heading", name="The face").wait_for()


class Gate:
    """Requests that are answered only when the test lets them."""

    def __init__(self, page, path):
        self.waiting, self.most = [], 1
        page.route(path, self._asked)

    def _asked(self, route):
        if len(self.waiting) < self.most:
            self.waiting.append(route)
        else:
            route.continue_()

    def open(self):
        self.waiting[0].continue_()


def test_of_two_photos_the_one_given_last_stays_though_it_is_looked_at_first(visit):
    gate = Gate(visit.page, "**/api/photo")
    visit.choose_photo(studios.picture(size=(300, 200)))
    visit.wait(lambda: gate.waiting)
    visit.page.evaluate("() => limnerApp.set({ loading: false })")
    visit.choose_photo(studios.face_jpeg())
    visit.page.locator(".card .facts").first.wait_for()
    with visit.page.expect_response("**/api/photo") as answer:
        gate.open()
    answer.value.finished()
    visit.until(SETTLED)
    assert visit.page.evaluate("() => limnerApp.state.photo.width") == 400


def test_an_arm_that_is_there_late_is_not_shown_in_place_of_the_plotter(drawn):
    gate = Gate(drawn.page, "**/api/robot/ur5e.json")
    drawn.page.evaluate("() => limnerApp.setSettings({ style: 'splines', 'page.size': 'a6' })")
    drawn.go("Watch")
    drawn.page.locator("#drawer").select_option("robot:ur5e")
    drawn.wait(lambda: gate.waiting)
    drawn.page.locator("#drawer").select_option("machine:grbl")
    drawn.until("() => limnerApp.state.plan?.times?.length && !limnerApp.state.robot")
    with drawn.page.expect_response("**/api/robot/ur5e.json") as answer:
        gate.open()
    answer.value.finished()
    drawn.page.locator("#drawer").select_option("robot:ur5e")
    drawn.page.get_by_role("button", name="From above", pressed=True).wait_for()


def two_faces():
    """The astronaut beside herself, as JPEG."""
    one = Image.open(io.BytesIO(studios.face_jpeg(360)))
    both = Image.new("RGB", (720, 360), "white")
    both.paste(one, (0, 0))
    both.paste(ImageOps.mirror(one), (360, 0))
    out = io.BytesIO()
    both.save(out, "JPEG", quality=92)
    return out.getvalue()


def test_of_two_faces_one_is_clicked_and_the_one_before_stays_among_the_recent(drawn):
    page = drawn.page
    few_lines(drawn)
    drawn.go("Photo")
    drawn.choose_photo(two_faces())
    page.get_by_role("heading", name="Who is it to be?").wait_for()
    assert drawn.violations() == []
    faces = drawn.page.evaluate("() => limnerApp.state.photo.faces.map(face => face.box_px[0])")
    right = faces.index(max(faces))
    page.get_by_role("button", name=f"Face {right + 1}").click()
    page.locator(".card .facts").first.wait_for()
    assert min(x for x, _ in drawn.until("() => limnerApp.landmarks")) > 340
    # They are the server's: a reload leaves them, and each is gone on with as it was left.
    page.reload()
    drawn.until("() => Boolean(globalThis.limnerApp)")
    drawn.go("Photo")
    drawn.until(
        "() => limnerApp.state.recents.length === 1 && limnerApp.state.recents[0].settings['page.size'] === 'a6'"
    )
    inked(drawn, 50, ".recents canvas:nth-child(2)")
    assert drawn.violations() == []
    page.locator(".recents button").first.click()
    drawn.until("() => limnerApp.state.screen === 'adjust' && limnerApp.state.photo.width === 400")
    drawn.until("() => limnerApp.state.preview?.final && limnerApp.state.preview.page.width_mm === 105")


def test_two_people_do_not_see_each_others_photos(server, browser, drawn):
    other = browsers.Visit(browser, server.url)
    photo = drawn.page.evaluate("() => limnerApp.state.photo.url")
    assert other.page.evaluate("url => fetch(url).then(answer => answer.status)", photo) == 404
    assert drawn.page.evaluate("url => fetch(url).then(answer => answer.status)", photo) == 200
    assert other.page.evaluate("() => limnerApp.state.photo") is None
    other.context.close()


def start_job(visit, machine="A simulated plotter, fast"):
    """Choose a machine, or leave it as it is; tick all that must be so; start."""
    page = visit.page
    visit.until("() => limnerApp.state.preview?.final")
    visit.go("Send")
    if machine:
        page.get_by_role("button", name=machine).click()
    start = page.get_by_role("button", name="Start drawing")
    page.get_by_role("checkbox").first.wait_for()
    assert start.is_disabled()
    visit.until("() => document.querySelectorAll('.panel input[type=checkbox]').length > 1")
    for box in page.get_by_role("checkbox").all():
        box.check()
    start.click()


def test_a_job_is_paused_reloaded_and_resumed_in_another_tab(server, browser, drawn):
    page = drawn.page
    start_job(drawn)
    page.get_by_role("button", name="Pause at the next lift").click()
    drawn.until("() => limnerApp.state.job.state === 'paused'")
    page.reload()
    page.get_by_role("heading", name="Paused").wait_for()
    other = browsers.Visit(browser, server.base, context=drawn.context)
    other.page.get_by_role("link", name="Paused").click()
    other.page.get_by_role("button", name="Go on").click()
    other.page.get_by_role("heading", name="Done").wait_for()
    page.get_by_role("heading", name="Done").wait_for()
    whole = ink(drawn)
    assert whole > 1000
    assert other.complaints == []
    page.get_by_role("button", name="Put away").click()
    drawn.until("() => limnerApp.state.job.state === 'idle'")
    # A reload leaves the drawing on the desk.
    page.get_by_role("button", name="Start drawing").wait_for()


def all_there(visit):
    """Wait until the screen has what it asked the server for."""
    visit.until(SETTLED)
    if visit.page.evaluate("() => ['watch', 'send'].includes(limnerApp.state.screen)"):
        visit.until("() => limnerApp.state.plan || limnerApp.state.planError")
    # Of the candidates some take long.
    for screen, some in (("face", "refinements.length"), ("choose", "candidates[2]")):
        visit.until(f"() => limnerApp.state.screen !== '{screen}' || limnerApp.state.{some}")


def few_lines(visit):
    """The drawing on the desk in nine lines, half a minute on a plotter."""
    visit.page.evaluate("() => limnerApp.setSettings({ style: 'splines', 'page.size': 'a6' })")
    visit.until(SETTLED)
    return visit.page.evaluate("() => limnerApp.state.preview.report.strokes")


def journalled(journal):
    """What the machine did, from the open file of a journal: strokes begun, strokes reached."""
    journal.seek(0)
    told = [line.split()[:2] for line in journal.read().splitlines()[1:]]
    return [[int(stroke) for word, stroke in told if word == wanted] for wanted in ("begin", "reached")]


def start_on(visit, address):
    """As ``start_job``, on a machine by its address."""
    visit.go("Send")
    visit.page.get_by_label("Or by its address").fill(address)
    visit.page.keyboard.press("Tab")
    start_job(visit, None)


def test_a_job_waits_for_the_next_pen_and_names_it(drawn):
    page = drawn.page
    page.evaluate(
        "() => limnerApp.setSettings({ style: 'cartoon', 'cartoon.pens': 2, 'page.size': 'a6', 'order.kicks': 0 })"
    )
    drawn.until(SETTLED)
    pens = page.evaluate("() => limnerApp.state.preview.report.pens.map(pen => pen.name)")
    assert len(pens) == 2
    start_on(drawn, "sim:1000")
    on = page.get_by_role("button", name="The next pen is in")
    on.wait_for()
    assert page.get_by_role("link", name="Next pen").is_visible()
    page.get_by_text(f"Put in the next one: {pens[1]}.").wait_for()
    assert drawn.violations() == []
    on.click()
    page.get_by_role("heading", name="Done").wait_for()
    page.get_by_role("button", name="Save").click()
    with page.expect_download() as saved:
        page.get_by_role("button", name="Picture in colours").click()
    assert saved.value.suggested_filename == "portrait.picture.png"
    with Image.open(saved.value.path()) as picture:
        assert len(picture.getcolors(2**24)) > 3
    page.get_by_role("button", name="Put away").click()
    drawn.until("() => limnerApp.state.job.state === 'idle'")


def test_a_server_killed_in_mid_job_comes_back_and_the_page_goes_on(browser, tmp_path):
    with contextlib.ExitStack() as stack:
        server = stack.enter_context(studios.serving(state=tmp_path))
        visit = browsers.Visit(browser, server.url)
        page, port = visit.page, server.port
        visit.choose_photo(studios.face_jpeg())
        page.locator(".card .facts").first.wait_for()
        strokes = few_lines(visit)
        # Slow, so that it is caught in the middle; the rest need not be.
        start_on(visit, "sim:1")
        visit.until("() => limnerApp.state.job.stroke >= 3")
        # Open, it can be read to its end although it is removed when all is drawn.
        journal = stack.enter_context(next(tmp_path.rglob("journal")).open())
        server.kill()
        server.hurry("sim:20")
        page.get_by_role("alert").filter(has_text="limner does not answer").wait_for()
        assert visit.violations() == []
        begun, reached = journalled(journal)
        assert 3 <= len(reached) < strokes
        server = stack.enter_context(studios.serving("--port", port, state=tmp_path))
        page.get_by_role("heading", name="Interrupted").wait_for()
        page.get_by_text("go on at the right stroke").wait_for()
        assert visit.violations() == []
        assert page.evaluate("() => limnerApp.state.job.mine")
        inked(visit, 200)
        half = ink(visit)
        # The tab that limner opens with the new token is the same person's.
        other = browsers.Visit(browser, server.url, context=visit.context)
        other.page.get_by_role("link", name="Interrupted").click()
        inked(other, 200)
        assert other.violations() == []
        page.get_by_role("button", name="Go on").click()
        page.get_by_role("heading", name="Done").wait_for()
        again, done = journalled(journal)
        # Every stroke is drawn, in order; only the one in doubt is begun a second time.
        assert sorted(set(again)) == list(range(strokes))
        assert again == sorted(again)
        assert len(again) - strokes == len(begun) - len(reached) <= 1
        assert done[-1] == strokes
        assert half < ink(visit)
        # The photo was sent anew: what is on the desk can be drawn and sent again.
        page.get_by_role("button", name="Put away").click()
        visit.go("Choose")
        page.locator(".card .facts").first.wait_for()
        assert not page.get_by_role("alert").filter(visible=True).count()
        visit.context.close()


def test_who_does_not_own_the_job_is_told_where_to_enter_again(browser, tmp_path):
    with studios.serving(state=tmp_path) as server:
        visit = browsers.Visit(browser, server.url)
        port = server.port
    with studios.serving("--port", port, state=tmp_path) as server:
        visit.page.get_by_role("alert").filter(has_text="Open the address that it printed").wait_for()
        assert visit.violations() == []
        other = browsers.Visit(browser, server.url, context=visit.context)
        visit.until("() => limnerApp.state.online")
        assert not visit.page.get_by_role("alert").filter(visible=True).count()
        assert other.complaints == []
        visit.context.close()


def test_a_job_is_stopped_and_the_frame_is_tried(drawn):
    page = drawn.page
    drawn.until("() => limnerApp.state.preview?.final")
    drawn.go("Send")
    page.get_by_role("button", name="A simulated plotter, fast").click()
    dry = page.get_by_role("button", name="Dry run round the frame")
    drawn.until("() => document.querySelectorAll('.panel input[type=checkbox]').length > 1")
    dry.click()
    page.get_by_role("heading", name="Done").wait_for()
    page.get_by_role("button", name="Put away").click()
    drawn.until("() => limnerApp.state.job.state === 'idle'")
    start_job(drawn, "A simulated plotter ready")
    page.get_by_role("button", name="Stop, pen up").click()
    page.get_by_role("heading", name="Stopped").wait_for()
    page.get_by_role("button", name="Put away").click()
    drawn.until("() => limnerApp.state.job.state === 'idle'")


@pytest.mark.parametrize("kind", ["svg", "gcode", "png"])
def test_the_drawing_is_saved(drawn, kind):
    drawn.until("() => limnerApp.state.preview?.final")
    drawn.page.get_by_role("button", name="Save").click()
    with drawn.page.expect_download() as saved:
        drawn.page.locator(f"[data-format={kind}]").click()
    assert saved.value.suggested_filename == f"portrait.{kind}"
    assert saved.value.path().stat().st_size > 500


def test_an_arm_is_watched_from_above(drawn):
    page = drawn.page
    drawn.until("() => limnerApp.state.preview?.final")
    drawn.go("Watch")
    page.locator("#drawer").select_option("robot:ur5e")
    drawn.until("() => limnerApp.state.plan?.joints?.length")
    page.get_by_role("button", name="From above", pressed=True).wait_for()
    page.get_by_role("slider", name="Time").fill("1")
    assert ink(drawn, ".above canvas:nth-child(1)") > 1000
    before = ink(drawn, ".above canvas:nth-child(2)")
    assert before > 500
    assert drawn.violations() == []
    page.get_by_role("button", name="Sheet").click()
    assert ink(drawn) > 1000


@pytest.fixture(scope="module")
def space():
    """Whether there is the 3-D view in one file; a package that was made without npm has none."""
    if not BUILT.exists() or BUILT.stat().st_mtime < SOURCE.stat().st_mtime:
        BUILT.unlink(missing_ok=True)
        subprocess.run(["make", "studio-3d"], cwd=ROOT, capture_output=True, timeout=300)
    return BUILT.exists()


def pixels(visit):
    """What the 3-D view shows, as RGB."""
    # It is shown with the next frame of the screen.
    visit.page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    # What the page lays over it would be seen too.
    return np.asarray(Image.open(io.BytesIO(visit.page.locator(".arm3d canvas").screenshot())).convert("RGB")).astype(
        int
    )


def red_and_dark(shown):
    """Pixels of the red pencil, and of ink."""
    red, green, blue = shown.transpose(2, 0, 1)
    return int(((red > green + 60) & (red > blue + 60)).sum()), int((shown.max(-1) < 110).sum())


def test_what_an_arm_cannot_reach_is_red_in_3d_before_anything_is_sent(server, browser, space):
    software = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")
    with browsers.another(browser, *software, without=["--disable-gpu"]) as other:
        visit = browsers.Visit(other, server.url)
        page = visit.page
        visit.choose_photo(studios.face_jpeg())
        page.locator(".card .facts").first.wait_for()
        page.evaluate("() => limnerApp.setSettings({ style: 'splines', 'arm.place.at': '0.92,0.1,0.0' })")
        visit.go("Watch")
        page.locator("#drawer").select_option("robot:ur5e")
        visit.until("() => limnerApp.state.planError")
        page.get_by_text("What is red cannot be reached.").wait_for()
        lost = page.evaluate("() => limnerApp.state.plan.unreachable.length / limnerApp.state.plan.lines")
        assert 0 < lost < 1
        page.get_by_role("button", name="3-D").click()
        if not space:
            page.get_by_text("The 3-D view is not in this installation").wait_for()
            page.get_by_role("button", name="From above", pressed=True).wait_for()
            visit.context.close()
            return
        page.get_by_text("Drag to turn").wait_for()
        visit.wait(lambda: red_and_dark(pixels(visit))[0] > 60, "red lines")
        shown = pixels(visit)
        assert red_and_dark(shown)[1] > 10
        assert len(np.unique(shown.reshape(-1, 3), axis=0)) > 200, "the arm is shaded"
        assert visit.violations() == []
        # From above the same lines are red.
        page.get_by_role("button", name="From above").click()
        assert ink(visit, ".above canvas:nth-child(2)") > 500
        assert red_ink(visit, ".above canvas:nth-child(1)") > 30
        page.evaluate("() => limnerApp.change({ 'arm.place.at': '0.7,0.1,0.0' })")
        visit.until("() => limnerApp.state.plan?.joints?.length")
        page.get_by_role("button", name="3-D").click()
        page.get_by_role("slider", name="Time").fill("0.5")
        visit.wait(lambda: red_and_dark(pixels(visit))[0] < 10, "no line is red any more")
        half = pixels(visit)
        page.get_by_role("slider", name="Time").fill("0.9")
        visit.wait(lambda: (abs(pixels(visit) - half).max(-1) > 30).sum() > 500, "the arm moves")
        more = pixels(visit)
        assert red_and_dark(more)[1] > red_and_dark(half)[1] - 50 > 0, "ink appears"
        assert visit.complaints == []
        visit.context.close()


def test_without_3d_the_page_says_so_and_shows_the_arm_from_above(server, browser):
    with browsers.another(browser, "--disable-3d-apis") as other:
        visit = browsers.Visit(other, server.url)
        visit.choose_photo(studios.face_jpeg())
        visit.page.locator(".card .facts").first.wait_for()
        visit.page.evaluate("() => limnerApp.setSettings({ style: 'splines', 'page.size': 'a6' })")
        visit.go("Watch")
        visit.page.locator("#drawer").select_option("robot:ur5e")
        visit.until("() => limnerApp.state.plan?.joints?.length")
        visit.page.get_by_role("button", name="3-D").click()
        visit.page.get_by_text("This browser shows no 3-D").wait_for()
        visit.page.get_by_role("button", name="From above", pressed=True).wait_for()
        assert ink(visit, ".above canvas:nth-child(2)") > 500
        assert visit.violations() == []
        assert visit.complaints == []
        visit.context.close()


@pytest.mark.parametrize("how", [{"color_scheme": "light"}, {"color_scheme": "dark"}], ids=["light", "dark"])
def test_every_screen_is_accessible(server, browser, how):
    visit = browsers.Visit(browser, server.url, **how)
    assert visit.violations() == []
    visit.choose_photo(studios.face_jpeg())
    visit.page.locator(".card .facts").nth(2).wait_for()
    for screen in SCREENS:
        visit.go(screen)
        all_there(visit)
        if screen == "Adjust":
            visit.page.get_by_text("Every setting").click()
        assert visit.violations() == [], screen
    visit.page.get_by_role("button", name="Save").click()
    assert visit.violations() == [], "saving"
    assert visit.complaints == []
    visit.context.close()


def test_the_whole_way_by_keys_on_a_narrow_calm_screen(server, browser):
    visit = browsers.Visit(browser, server.url, reduced_motion="reduce")
    visit.page.set_viewport_size({"width": 375, "height": 740})
    # For whoever wants no movement the example is drawn at once.
    inked(visit, 500, ".easel canvas:nth-child(2)")
    visit.page.keyboard.press("Tab")
    visit.page.keyboard.press("Enter")
    visit.choose_photo(studios.face_jpeg())
    visit.page.locator(".card .facts").nth(1).wait_for()
    wide = "() => document.documentElement.scrollWidth <= innerWidth"
    for screen in SCREENS:
        visit.go(screen)
        all_there(visit)
        assert visit.page.evaluate(wide), f"{screen} is wider than the screen"
    visit.go("Choose")
    all_there(visit)
    second = visit.page.locator(".card:has(.facts)").nth(1)
    assert second.get_attribute("aria-pressed") == "false"
    second.focus()
    visit.page.keyboard.press("Enter")
    visit.page.locator(".cards li:nth-child(2) .card[aria-pressed=true]").wait_for()
    visit.go("Watch")
    assert visit.page.get_by_role("button", name="Play").is_visible()
    visit.context.close()


def test_a_guest_of_the_booth_is_drawn_and_the_booth_begins_again(browser):
    with studios.serving("--booth") as booth:
        guest = browsers.Visit(browser, booth.url)
        # A busy machine is no guest who has gone.
        guest.page.evaluate("() => Object.assign(limnerApp.rules, { reset_s: 9999, ticket_s: 9999 })")
        assert guest.violations() == []
        guest.page.get_by_role("button", name="Touch to be drawn").click()
        guest.page.locator(".three button").nth(2).wait_for()
        assert guest.violations() == []
        guest.page.locator(".three button").nth(1).click()
        guest.page.get_by_role("heading", name="You are in the queue").wait_for()
        assert guest.violations() == []
        operator = browsers.Visit(browser, booth.said["operator_url"], context=browser.new_context())
        operator.page.get_by_text("1 in the queue").wait_for()
        assert operator.violations() == []
        operator.page.get_by_label("Drawn by").select_option("machine:grbl")
        operator.page.get_by_label("Where").select_option("sim:20")
        operator.page.get_by_role("button", name="Use this machine").click()
        operator.page.get_by_text("The next is drawn at sim:20.").wait_for()
        assert operator.violations() == []
        assert operator.page.evaluate("() => limnerApp.store.get().machine") == "grbl"
        operator.page.set_viewport_size({"width": 375, "height": 740})
        assert operator.page.evaluate("() => document.documentElement.scrollWidth <= innerWidth")
        operator.page.get_by_role("button", name="Begin the next").click()
        guest.page.get_by_text("It is drawn.").wait_for()
        guest.page.get_by_role("button", name="Done").click()
        guest.page.get_by_role("button", name="Touch to be drawn").wait_for()
        # Its place in the queue may be answered after it was told that it is drawn.
        entry = {"entry": "mine", "place": 1, "left_s": 60}
        script = """entry => {
            limnerApp.guest.entry = entry.entry;
            limnerApp.heard({ type: 'queue', queue: [{ ...entry, state: 'done' }] }, null);
            limnerApp.ticket({ ...entry, state: 'waiting' });
        }"""
        guest.page.evaluate(script, entry)
        assert guest.page.get_by_text("It is drawn.").is_visible()
        assert guest.complaints == operator.complaints == []
        guest.context.close()
        operator.context.close()

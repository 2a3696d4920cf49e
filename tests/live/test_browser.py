"""The page in a browser: opened from disk with no way to the network, run, moved, read, taken away; by keys
alone, and on a phone.

Where there is no Chromium, or no Playwright to drive it, these tests are skipped and the rest runs.
"""

import base64
import dataclasses
from pathlib import Path

import numpy as np
import pytest

from live.browsers import needs_browser
from live.pages import page_of
from vfife import gallery
from vfife.compiler.runtime.runner import Runner
from vfife.live.page.page import page_with_sliders
from vfife.live.page.patches import slider_patches
from vfife.live.page.sliders import parse_slides
from vfife.modelfile import loads
from vfife.plots.turn import CRANK_ANGLE
from vfife.solvers.record import recorded_rows

pytestmark = needs_browser
EVIL = '<img src=x onerror="window.struck=1"><b>bold</b>'


@pytest.fixture
def opened(browser, tmp_path):
    """Opens a page from disk; whatever it asks of the network, and whatever goes wrong in it,
    fails the test.
    """
    faults: list[str] = []
    contexts = []

    def open_page(text: str, **options):
        path = tmp_path / f"page{len(contexts)}.html"
        path.write_text(text, "utf-8")
        context = browser.new_context(accept_downloads=True, **options)
        contexts.append(context)

        def let(route):
            if not route.request.url.startswith(("file://", "blob:", "data:")):
                faults.append(f"asked for {route.request.url}")
                route.abort()
            else:
                route.continue_()

        context.route("**/*", let)
        page = context.new_page()
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda message: faults.append(message.text) if message.type == "error" else None)
        page.goto(path.as_uri())
        page.wait_for_function("() => live.running.store.end > 1")
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert faults == []


def with_ends(slides):
    """Sliders with three positions: the ends and the model's own."""
    return [
        dataclasses.replace(one, values=(one.values[0], one.values[one.here], one.values[-1]), here=1)
        for one in slides
    ]


def outputs_of(page, until: int) -> np.ndarray:
    """The rows that the page keeps of outputs 0 to ``until``, as their bits."""
    page.wait_for_function(f"() => live.running.store.end > {until}")
    text = page.evaluate(
        """(until) => {
          const { store } = live.running;
          const bytes = new Uint8Array(store.data.slice(0, (until + 1) * store.width).buffer);
          let text = "";
          for (let k = 0; k < bytes.length; k += 8192)
            text += String.fromCharCode(...bytes.subarray(k, k + 8192));
          return btoa(text);
        }""",
        until,
    )
    return np.frombuffer(base64.b64decode(text), dtype=np.uint64).reshape(until + 1, -1)


def bits_of(both, until: int) -> np.ndarray:
    """What Python makes of the same outputs."""
    own = both.assembly
    runner = Runner(
        own.topology,
        own.state[:, None],
        own.tables,
        "data-driven",
        recorded_rows(own),
        parts=own.mechanism.settings.parts,
    )
    rows = np.concatenate([runner.advance(1, 1), runner.advance(own.choice.outputs_every, until)])[:, :, 0]
    return np.ascontiguousarray(rows).view(np.uint64)  # the page keeps more behind these


def same(page, both, until: int) -> bool:
    """Whether the page has the bits of Python."""
    wanted = bits_of(both, until)
    return bool((outputs_of(page, until)[:, : wanted.shape[1]] == wanted).all())


@pytest.mark.slow("a browser")
def test_it_runs_from_disk_with_the_bits_of_python_and_so_does_a_slider(opened):
    mechanism = gallery.four_bar_case_b()
    slides = with_ends(parse_slides(mechanism, ["joint.C.clearance=0.1..0.3mm"]))
    found = slider_patches(mechanism, slides)
    page = opened(page_with_sliders(found))
    assert same(page, found.base, 720)
    page.locator("#slide-0").focus()
    page.keyboard.press("End")
    page.wait_for_function("() => live.running.id === 2")
    last = len(slides[0].values) - 1
    base = found.base.assembly.choice
    moved = slider_patches(loads(page.evaluate("() => live.sliders.setting.model")), [], base.step).base
    assert moved.assembly.mechanism.joints["C"].clearance == slides[0].values[last]
    assert same(page, moved, 720)


@pytest.mark.slow("a browser")
def test_clearance_circles_do_not_cover_the_machine_after_a_slider(opened):
    """The enlargement that suits 0.2 mm draws a circle of a third of the machine at 3 mm; a change that fits
    leaves the enlargement as it is.
    """
    mechanism = gallery.four_bar_case_b()
    for largest, changes in (("0.3", False), ("3", True)):
        slides = with_ends(parse_slides(mechanism, [f"joint.C.clearance=0.1..{largest}mm"]))
        page = opened(page_with_sliders(slider_patches(mechanism, slides)))
        page.wait_for_function("() => live.clock.sized")
        before = page.evaluate("() => live.scene.magnify")
        page.locator("#slide-0").focus()
        page.keyboard.press("End")
        page.wait_for_function("() => live.running.id === 2")
        share = "() => live.scene.magnify * Math.max(...live.running.reader.plays) / live.scene.size"
        assert page.evaluate(share) < 0.09
        assert (page.evaluate("() => live.scene.magnify") < before) == changes


def test_rounding_of_nothing_is_nothing(opened):
    page = opened(page_of(gallery.four_bar_case_b()))
    words = page.evaluate('() => [1e-300, 0, 2.5e-9, 1200].map((force) => live.quantity(force, "N"))')
    assert words == ["0 N", "0 N", "0.0025 µN", "1.2 kN"]
    counts = page.evaluate('() => [0, 1e-300, 7].map((count) => live.quantity(count, "1"))')
    assert counts == ["0", "0", "7"]


def test_names_are_text_and_nothing_else(opened):
    mechanism = gallery.four_bar_case_b()
    mechanism.name = mechanism.note = EVIL
    page = opened(page_of(mechanism))
    assert page.inner_text("#name") == EVIL
    assert page.locator("h1 *").count() == page.locator("#note *").count() == 0
    assert page.evaluate("() => window.struck") is None


@pytest.mark.system("a browser")
def test_everything_goes_by_keys(opened):
    mechanism = gallery.four_bar_case_b()
    page = opened(page_of(mechanism, with_ends(parse_slides(mechanism, ["joint.C.clearance=0.1..0.3mm"]))))
    page.wait_for_function("() => live.running.store.end > 1000")
    page.keyboard.press(" ")
    assert page.get_attribute("#play", "aria-label") == "play"
    head = page.evaluate("() => Math.round(live.clock.head)")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Shift+ArrowRight")
    page.keyboard.press("ArrowLeft")
    assert page.evaluate("() => live.clock.head") == head + 20
    last = page.evaluate("() => live.running.store.end - 1")
    page.keyboard.press("End")
    assert page.evaluate("() => live.clock.head") >= last
    for key, what in (("j", "live.selected.joint"), ("t", "document.documentElement.dataset.theme")):
        before = page.evaluate(f"() => {what}")
        page.keyboard.press(key)
        assert page.evaluate(f"() => {what}") != before
    for there in (True, False):
        page.keyboard.press("k")
        assert page.locator("#comparison").is_visible() is there
    page.keyboard.press("?")
    assert page.locator("#keys").is_visible()
    page.keyboard.press("Escape")
    reached = set()
    for _ in range(40):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("() => document.activeElement.id"))
    assert {
        "play",
        "back",
        "forth",
        "scrub",
        "speed",
        "magnify",
        "slide-0",
        "keep",
        "theme",
        "help",
    } <= reached


@pytest.mark.system("a browser")
def test_what_is_taken_away(opened):
    """Model, numbers and pictures: the numbers are those of the outputs, in as many lines; pictures are
    well-formed.
    """
    from xml.etree import ElementTree

    mechanism = gallery.slider_crank_loose_guide()
    page = opened(page_of(mechanism))
    page.wait_for_function("() => live.running.store.end > 400")
    page.keyboard.press(" ")

    def taken(selector: str, opener: bool = True) -> Path:
        if opener:
            page.evaluate("() => { document.getElementById('take').open = true; }")
        with page.expect_download() as download:
            page.click(selector)
        return Path(download.value.path())

    assert loads(taken("#get-model").read_text("utf-8")) == mechanism
    lines = taken("#get-csv").read_text("utf-8").splitlines()
    head, first = lines[0].split(","), lines[1].split(",")
    assert len(head) == len(first) and head[0] == "time (s)" and float(first[0]) == 0.0
    assert taken("#get-png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    for selector, opener in (
        ("#get-svg", True),
        ("#forces button:has-text('SVG')", False),
        ("#orbits button:has-text('SVG')", False),
    ):
        text = taken(selector, opener).read_text("utf-8")
        assert ElementTree.fromstring(text).tag.endswith("svg") and "NaN" not in text


@pytest.mark.system("a browser")
def test_it_fits_a_phone_in_light_and_dark_and_drawing_does_not_wait_for_steps(opened):
    page = opened(
        page_of(gallery.quick_return()),
        viewport={"width": 360, "height": 740},
        color_scheme="light",
        has_touch=True,
        is_mobile=True,
    )
    drawn = page.evaluate("() => live.frames.count")
    page.wait_for_function(f"() => live.frames.count > {drawn} + 20 && live.running.store.end > 800")
    assert page.evaluate("() => document.documentElement.scrollWidth <= window.innerWidth")
    assert page.evaluate("() => document.documentElement.dataset.theme") == "light"
    page.emulate_media(color_scheme="dark")
    page.wait_for_function("() => document.documentElement.dataset.theme === 'dark'")
    assert page.locator("#play").is_visible() and page.locator("#scene").is_visible()
    box = page.locator("#play").bounding_box()
    assert box["height"] >= 30 and box["width"] >= 40


@pytest.mark.system("a browser")
def test_the_mechanism_fills_its_canvas_and_names_stand_beside_pins(opened):
    """At a desk and on a phone: what moves takes most of the canvas; no name lies on a pin or on another
    name.
    """
    for width in (1280, 420):
        page = opened(page_of(gallery.six_bar_press()), viewport={"width": width, "height": 800})
        page.wait_for_function("() => live.clock.sized")
        page.wait_for_timeout(300)
        page.keyboard.press(" ")
        shares = page.evaluate(
            """() => {
              const box = document.getElementById("scene").getBoundingClientRect();
              return live.scene.span.map(
                (size, axis) => size * live.scene.scale / [box.width, box.height][axis]);
            }"""
        )
        assert max(shares) > 0.75 and min(shares) > 0.5, (width, shares)
        covered = page.evaluate(
            """() => {
              const { scene } = live, texts = [], { to, pose } = scene.last;
              const pen = { font: "", measureText: (text) => ({ width: 7 * text.length }), strokeText() {},
                            fillText: (text, x, y) => texts.push([text, x, y]) };
              scene.names(pen, to, pose);
              const pins = scene.circles(to, pose).slice(0, 14);
              const on = ([text, x, y], [a, b]) => Math.abs(a - x) < 3.5 * text.length && Math.abs(b - y) < 7;
              const overlap = (one, two) =>
                Math.abs(one[1] - two[1]) < 3.5 * (one[0].length + two[0].length) &&
                Math.abs(one[2] - two[2]) < 14;
              return [texts.length, texts.filter((text) => pins.some((pin) => on(text, pin))).length,
                      texts.filter((one, k) => texts.slice(k + 1).some((two) => overlap(one, two))).length];
            }"""
        )
        assert covered[0] == 12 and covered[1:] == [0, 0], (width, covered)


WRITTEN = """([id, width, height]) => {
  // What a chart writes on a canvas: texts with their ends and their height
  const canvas = document.createElement("canvas"), pen = canvas.getContext("2d"), texts = [];
  pen.fillText = (text, x, y, room) => {
    const half = 0.5 * Math.min(pen.measureText(text).width, room ?? Infinity);
    texts.push([text, x - half, x + half, y]);
  };
  live.cards.find((card) => card.id === id).draw(pen, width, height, live.running, live.clock.head, null);
  return texts;
}"""


@pytest.mark.system("a browser")
def test_charts_stay_readable_on_a_phone_and_show_one_moment(opened):
    page = opened(page_of(gallery.compressor()), viewport={"width": 420, "height": 2900})
    page.wait_for_function("() => live.clock.sized && live.running.turns.shown.length > 1", timeout=60_000)
    page.wait_for_timeout(800)
    page.keyboard.press(" ")
    page.wait_for_timeout(600)
    titles = page.evaluate(WRITTEN, ["orbits", 372, 210])
    assert len(titles) == 8, "three names and their clearances, two forces"
    for name, left, right, height in titles:
        for other, begin, end, level in titles:
            assert name == other or abs(height - level) > 8 or right < begin or left > end, (name, other)
    assert CRANK_ANGLE in [text for text, *_ in page.evaluate(WRITTEN, ["forces", 600, 240])]

    def moments() -> list[float]:
        return page.evaluate(
            "() => live.cards.filter((one) => one.moment).map((one) => one.line.getBoundingClientRect().x)"
        )

    lines = moments()
    assert len(lines) == 2 and abs(lines[0] - lines[1]) < 20.0, "charts have margins of their own"
    page.evaluate("() => { live.frames.before = live.frames.count; }")
    page.keyboard.press("Shift+ArrowRight")
    page.wait_for_function("() => live.frames.count > live.frames.before + 2")
    assert all(abs(after - before) > 3.0 for before, after in zip(lines, moments(), strict=True))
    stored = float(page.inner_text("#energy p").split("kinetic ")[1].split(" J")[0])
    written = page.evaluate(WRITTEN, ["energy", 600, 240])
    ticks = [float(text) for text, left, *_ in written if left < 40 and text.replace(".", "").isdigit()]
    assert "energy since the turn began (J)" in [text for text, *_ in written]
    assert 0.0 < max(ticks) < 0.5 * stored, "a flywheel's energy does not press all others onto the axis"


VERTICAL = """
name = "ram"
gravity = [0, "-9.81 m/s^2"]
[ground]
O = [0, 0]
[body.ram]
mass = 1
inertia = 1
position = [0, 1]
[joint.guide]
kind = "slider"
bearing = "ground.O"
journal = "ram.center"
direction = [0, 1]
[spring.s]
first = "ground.O"
second = "ram.center"
stiffness = 100
free_length = "0.9 m"
[run]
duration = 1
"""


def test_the_phase_portrait_begins_with_a_coordinate_that_moves(opened):
    page = opened(page_of(loads(VERTICAL)))
    page.wait_for_function("() => live.clock.sized")
    assert page.evaluate("() => [live.selected.body, live.selected.quantity]") == ["ram", "y"]


def test_one_slider_moves_all_clearances(opened):
    mechanism = gallery.compressor()
    slides = with_ends(parse_slides(mechanism, [
        "joint.big-end.clearance=10..40um", "joint.small-end.clearance=5..20um"
    ]))  # fmt: skip
    page = opened(page_of(mechanism, slides))
    shared = page.get_by_label("all clearances", exact=True)
    shared.fill("2")
    assert page.evaluate("() => live.sliders.setting.positions") == [2, 2]
    assert page.evaluate("() => live.sliders.all.output.textContent") == "2 times the model"
    page.get_by_label("all clearances as in the model").click()
    assert page.evaluate("() => live.sliders.setting.positions") == [1, 1]


CLEARANCES = (
    "() => live.sliders.clearances"
    ".map((s) => live.sliders.inputs[s].slide.values[live.sliders.setting.positions[s]])"
)


def test_the_slider_for_all_clearances_states_the_factor_of_each(opened):
    """Its range is the one that all have: 0.5 to 2 of the first joint, 0.2 to 1.5 of the second."""
    mechanism = gallery.compressor()
    names = ("big-end", "small-end")
    own = [mechanism.joints[name].clearance for name in names]
    ranges = ((0.5, 2.0), (0.2, 1.5))
    page = opened(page_of(mechanism, parse_slides(mechanism, [
        f"joint.{name}.clearance={low * value * 1e6:.6g}..{high * value * 1e6:.6g}um"
        for name, value, (low, high) in zip(names, own, ranges, strict=True)
    ])))  # fmt: skip
    shared = page.get_by_label("all clearances", exact=True)
    count = int(shared.get_attribute("max")) + 1
    assert count >= 15, "three quarters of the twenty positions that each of two such sliders has"
    factors = []
    for position in range(count):
        shared.fill(str(position))
        text = page.evaluate("() => live.sliders.all.output.textContent")
        factors.append(1.0 if text == "as in the model" else float(text.removesuffix(" times the model")))
        assert page.evaluate(CLEARANCES) == pytest.approx([factors[-1] * value for value in own], rel=5e-3)
        found = [value / mine for value, mine in zip(page.evaluate(CLEARANCES), own, strict=True)]
        assert found[0] == pytest.approx(found[1], rel=1e-9)
    assert (factors[0], factors[-1]) == (0.5, 1.5)
    page.locator("#slide-0").fill("0")
    assert page.evaluate("() => live.sliders.all.output.textContent") == "no common factor"

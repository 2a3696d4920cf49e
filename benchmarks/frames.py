"""What the eye gets: frames a second of every mechanism of the gallery in its page, and how soon a changed
model moves in the served one.

In a headless Chromium that draws without a graphics card, which is the harder case. Frames are those that the
browser asks the page for, so that whatever holds it up counts; drawing is the part of a frame's time that the
page's own script takes.
"""

from __future__ import annotations

import shutil
import statistics
import tempfile
from pathlib import Path
from typing import Any

from measure import EXAMPLES, Options, Part, table

from vfife import gallery
from vfife.live import live_page

LEAST = 30.0  # frames a second
SOON = 0.3  # s
SIZE = {"width": 1400, "height": 900}
SWITCHES = ("--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking")
MODEL = EXAMPLES / "four_bar_case_c.toml"
COUNTED = """async (ms) => {
  const [from, at] = [live.frames.count, performance.now()];
  await new Promise((done) => setTimeout(done, ms));
  const spent = [...live.frames.spent].sort((a, b) => a - b);
  const share = (q) => spent[Math.floor(q * (spent.length - 1))];
  const frames = (1000 * (live.frames.count - from)) / (performance.now() - at);
  return { frames, drawing: share(0.5), slow: share(0.95) };
}"""
CHANGED = """async (value) => {
  shell.took = null;
  await set(["joint", "C", "clearance"], value);
  while (shell.took === null) await new Promise(requestAnimationFrame);
  const last = (what) =>
    performance.getEntriesByType("resource").filter((one) => one.name.includes(what)).at(-1);
  const [sent, asked] = [last("/set"), last("/page")];
  return { all: shell.took, examined: sent.duration, assembled: asked.responseEnd - asked.startTime };
}"""


def measure(options: Options) -> Part:
    """Frames a second by mechanism, and times from a changed value to its first frame."""
    part = Part()
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        chromium = None
    if chromium is None:
        part.notes.append(
            "frames: left out; it takes the package chromium, and playwright in this environment"
        )
        return part
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=list(SWITCHES))
        found = {
            name: frames(browser, name, options)
            for name in gallery.__all__
            if getattr(gallery, name)().settings.analysis == "dynamic"
        }
        times = changes(browser, 4 if options.quick else 10)
        browser.close()
    soon = {name: statistics.median(one[name] for one in times) / 1000.0 for name in times[0]}
    part.ratios = {
        "frames.least": min(one["frames"] for one in found.values()) / LEAST,
        "frames.new_model": soon["all"] / SOON,
    }
    part.measured = {"frames_per_s": found, "new_model_s": soon, "new_model_ms": times}
    rows: list[tuple[Any, ...]] = [
        (name, f"{one['frames']:.0f}", f"{one['drawing']:.1f}", f"{one['slow']:.1f}")
        for name, one in found.items()
    ]
    part.tables.append(
        table(
            "pages of the gallery",
            "mechanism",
            "frames/s",
            "ms of drawing, median",
            "95 of 100 below",
            rows=rows,
        )
    )
    rows = [
        ("the value examined, and the text with it", soon["examined"]),
        ("assembled, traced where it is new, sent", soon["assembled"]),
        ("read by the browser, stepped and drawn", soon["all"] - soon["examined"] - soon["assembled"]),
        ("all", soon["all"]),
    ]
    part.tables.append(
        table("seconds from a changed clearance of case c to its first frame", "part", "s", rows=rows)
    )
    return part


def frames(browser: Any, name: str, options: Options) -> dict[str, float]:
    """Of one mechanism, once it has found its size and speed."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "page.html"
        path.write_text(live_page(getattr(gallery, name)()), "utf-8")
        page = browser.new_page(viewport=SIZE)
        page.goto(path.as_uri())
        page.wait_for_function("() => live.clock.sized && live.running.store.end > 2")
        page.wait_for_timeout(300 if options.quick else 1500)
        found: dict[str, float] = page.evaluate(COUNTED, 1000 if options.quick else 4000)
        page.close()
    return found


def changes(browser: Any, count: int) -> list[dict[str, float]]:
    """Times (ms) of so many changes of case c, the first of which is left out: it waits for what is read
    once.
    """
    from vfife.live.server.app import served
    from vfife.live.server.session import Session

    session = Session(EXAMPLES)
    document = session.shelf.from_file(MODEL)
    with served(session) as serving:
        page = browser.new_page(viewport=SIZE)
        page.goto(f"{serving.address}#{document.id}")
        page.wait_for_function("() => shell.frame")
        found = []
        for k in range(count + 1):
            page.wait_for_timeout(400)
            found.append(page.evaluate(CHANGED, f"{0.2 + 0.01 * (k + 1):.2f} mm"))
        page.close()
    return found[1:]

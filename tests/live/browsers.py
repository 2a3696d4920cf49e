"""The browser of the tests of pages, and its mouse on the drawing of a served page."""

import importlib.util
import shutil

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
WHY = "needs a browser: install the package chromium, and playwright into the environment of the tests"
needs_browser = pytest.mark.skipif(
    CHROMIUM is None or importlib.util.find_spec("playwright") is None, reason=WHY
)
SWITCHES = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
)  # fmt: skip


def pixel(page, expression):
    """Where a place of the drawing is on the page: an expression of the sketch ``s``."""
    return page.evaluate(
        "(expression) => { const s = shell.sketch; const box = s.canvas.getBoundingClientRect();"
        " const [x, y] = s.view.to(new Function('s', `return ${expression}`)(s));"
        " return [box.left + x, box.top + y]; }",
        expression,
    )


def drag(page, expression, dx, dy):
    """Drags a place of the drawing by pixels, in steps as a hand does."""
    x, y = pixel(page, expression)
    page.mouse.move(x, y)
    page.mouse.down()
    for share in (0.3, 0.6, 1.0):
        page.mouse.move(x + share * dx, y + share * dy)
        page.wait_for_timeout(60)
    page.mouse.up()


def drawn(page):
    page.click("#draw")
    page.wait_for_function("() => shell.sketch.drawing && shell.sketch.view.scale > 0")

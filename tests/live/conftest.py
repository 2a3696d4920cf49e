"""One browser for all tests of pages in a process, and a model that is served to it."""

import re

import pytest

from live.browsers import CHROMIUM, SWITCHES
from vfife import gallery
from vfife.modelfile import dump

EVIL = '<img src=x onerror="window.struck=1"><b>bold</b>'
WRONG = r"status of (409|422)"  # answers that a browser's console tells of, and that are meant


@pytest.fixture(scope="session")
def browser():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=CHROMIUM, args=list(SWITCHES))
        yield found
        found.close()


@pytest.fixture
def bar(tmp_path):
    mechanism = gallery.four_bar_case_b()
    mechanism.note = EVIL
    path = tmp_path / "bar.toml"
    path.write_text("# kept\n" + dump(mechanism), "utf-8")
    return path


@pytest.fixture
def visit(browser, bar):
    """Opens the page that is served; what goes wrong in it, and whatever it asks of another address, fails
    the test.
    """
    from vfife.live.server.app import served
    from vfife.live.server.session import Session

    faults, contexts = [], []
    session = Session(bar.parent, slide=["joint.C.clearance=0.15..0.3mm"], sliders=False)
    first = session.shelf.from_file(bar)
    session.pages.first = first.id
    with served(session) as serving:

        def opened(where=f"#{first.id}", **options):
            context = browser.new_context(**options)
            contexts.append(context)
            page = context.new_page()
            page.on("pageerror", lambda error: faults.append(str(error)))
            page.on(
                "console",
                lambda told: (
                    faults.append(told.text)
                    if told.type == "error" and not re.search(WRONG, told.text)
                    else None
                ),
            )
            page.on(
                "request",
                lambda one: (
                    faults.append(one.url)
                    if not one.url.startswith((serving.address, "blob:", "data:"))
                    else None
                ),
            )
            page.set_default_timeout(12000)
            page.goto(serving.address + where)
            return page

        opened.serving, opened.session, opened.browser = serving, session, browser
        yield opened
        for context in contexts:
            context.close()
    assert faults == []

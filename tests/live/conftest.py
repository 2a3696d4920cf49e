"""One browser for all tests of pages in a process."""

import pytest

from live.browsers import CHROMIUM, SWITCHES


@pytest.fixture(scope="session")
def browser():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=CHROMIUM, args=list(SWITCHES))
        yield found
        found.close()

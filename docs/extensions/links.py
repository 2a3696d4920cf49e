"""After a build, every link of every page is followed to its file and its place there, and no page may ask
for anything from elsewhere.

Builders look after links between sources; what is written as HTML, live pages and pictures, they do not see.
"""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

LOADED = {
    ("img", "src"),
    ("script", "src"),
    ("iframe", "src"),
    ("link", "href"),
    ("source", "src"),
    ("video", "src"),
}  # without a click
RELATIONS = ("stylesheet", "icon", "preload", "modulepreload")


class Page(HTMLParser):
    """The places of a page and what it leads to: ``(tag, attribute, target)``."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.places: set[str] = set()
        self.led: list[tuple[str, str, str]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        told = dict(attrs)
        self.places |= {value for name in ("id", "name") if (value := told.get(name))}
        if tag == "link" and told.get("rel") not in RELATIONS:
            return
        self.led += [(tag, name, value) for name in ("href", "src") if (value := told.get(name))]


def faults(folder: Path) -> list[str]:
    """What is wrong with the links of the pages in a folder, live pages apart, which have none."""
    pages = {
        path: Page(path.read_text(encoding="utf-8"))
        for path in folder.rglob("*.html")
        if path.parent.name != "live"
    }
    told = (
        (path, fault(path, led, pages, folder)) for path, page in sorted(pages.items()) for led in page.led
    )
    return [f"{path.relative_to(folder)}: {one}" for path, one in told if one]


def fault(path: Path, led: tuple[str, str, str], pages: dict[Path, Page], folder: Path) -> str:
    """What is wrong with a link, or nothing."""
    tag, attribute, target = led
    parts = urlsplit(target)
    if parts.scheme or parts.netloc:
        loaded = (tag, attribute) in LOADED and parts.scheme != "data"
        return f"{target} is loaded from elsewhere" if loaded else ""
    place = (path.parent / unquote(parts.path)).resolve() if parts.path else path
    if not place.exists():
        return f"{target} leads nowhere"
    if parts.fragment and place in pages and unquote(parts.fragment) not in pages[place].places:
        return f"{target}: there is no such place on {place.relative_to(folder)}"
    return ""


def follow(app: Any, error: Exception | None) -> None:
    """Each fault is a warning, and so an error of the build."""
    from sphinx.util import logging

    if error is None and app.builder.name == "html":
        for one in dict.fromkeys(faults(Path(app.outdir).resolve())):
            logging.getLogger(__name__).warning("%s", one)


def setup(app: Any) -> dict[str, bool]:
    app.connect("build-finished", follow, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

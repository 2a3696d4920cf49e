"""Pages of models: first the mechanism that runs, then, when all their positions are assembled, its
sliders.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import lru_cache
from typing import Any

from ... import gallery
from ...errors import VfifeError
from ..page.page import LARGEST, live_page, written
from ..page.patches import slider_patches
from ..page.sliders import default_slides, parse_slides
from .documents import Document

Key = tuple[str, int]  # a document and its version
CACHED = 12  # pages
PAUSE = 0.5  # s, for which sliders wait for a page at most


class Superseded(BaseException):
    """Sliders of a model that has changed since; no error, which would be taken for one of the model."""


class Pages:
    """Makes pages; ``notify`` is called with what a browser shall know. Sliders are assembled by a thread
    that yields to whoever waits for a page.
    """

    def __init__(
        self,
        notify: Callable[[dict[str, Any]], None],
        slide: Sequence[str] | None = None,
        sliders: bool = True,
    ) -> None:
        self.notify, self.slide, self.sliders = notify, slide, sliders
        self.first: str | None = None  # the document that --slide is for
        self.cache: OrderedDict[tuple[Key, bool], str] = OrderedDict()
        self.queue: OrderedDict[str, Document] = OrderedDict()
        self.current: Key | None = None
        self.superseded = False  # whether another document was requested since the sliders in work were begun
        self.building, self.changed, self.closed = threading.Lock(), threading.Condition(), False
        self.prepared: dict[str, Document] = {}  # documents whose page is made before a browser asks
        for work, name in ((self._work, "sliders"), (self._make_ahead, "pages")):
            threading.Thread(target=work, name=name, daemon=True).start()

    def page(self, document: Document, full: bool = False) -> str:
        """The page of a document as it is; with its sliders where they are there and asked for. Raises
        VfifeError where it cannot run.
        """
        key = document.id, document.version
        if full and (key, True) in self.cache:
            return self.cache[key, True]
        with self.building:
            key = document.id, document.version  # of what changed while we waited, only the last is made
            if (key, False) not in self.cache:
                self._keep(key, False, live_page(document.mechanism, [], document.its_step))
        self._want(document, key)
        return self.cache[key, False]

    def ahead(self, document: Document) -> None:
        """Begin the page of a document that has changed, which browsers are about to ask for; pages begun
        before count no more.
        """
        with self.changed:
            self.prepared[document.id] = document
            self.changed.notify_all()

    def _make_ahead(self) -> None:
        """Make pages ahead, one after the other, in the only thread that does."""
        while True:
            with self.changed:
                while not self.prepared and not self.closed:
                    self.changed.wait()
                if self.closed:
                    return
                _, document = self.prepared.popitem()
            with suppress(VfifeError, ValueError, ArithmeticError):  # told to who asks for it
                self.page(document)

    def _keep(self, key: Key, full: bool, page: str) -> None:
        self.cache[key, full] = page
        while len(self.cache) > CACHED:
            self.cache.popitem(last=False)

    # ------------------------------------------------------------------------------------------------ sliders

    def _want(self, document: Document, key: Key) -> None:
        if not self.sliders or document.mechanism.settings.analysis == "static":
            self.notify({"kind": "sliders", "id": key[0], "version": key[1], "said": ""})
            return
        if (key, True) in self.cache:
            self.notify({"kind": "sliders", "id": key[0], "version": key[1]})
            return
        with self.changed:
            if self.current != key:
                self.queue[document.id] = document
                self.queue.move_to_end(document.id)
                self.superseded = True
            self.changed.notify_all()

    def _work(self) -> None:
        while True:
            with self.changed:
                while not self.queue and not self.closed:
                    self.changed.wait()
                if self.closed:
                    return
                _, document = self.queue.popitem()
                self.superseded = False
                mechanism, step = document.mechanism, document.its_step
                self.current = document.id, document.version
            self._assemble(document, self.current, mechanism, step)
            self.current = None

    def _assemble(self, document: Document, key: Key, mechanism: Any, step: float | None) -> None:
        def before_assembly() -> None:
            if self.closed or document.version != key[1]:
                raise Superseded
            if self.superseded:  # what was asked for last goes first; this one begins anew after it
                with self.changed:
                    self.queue.setdefault(document.id, document)
                    self.queue.move_to_end(document.id, last=False)
                raise Superseded
            if self.building.acquire(timeout=PAUSE):  # whoever waits for a page goes first
                self.building.release()

        about = {"kind": "sliders", "id": key[0], "version": key[1]}
        try:
            slides = (
                parse_slides(mechanism, self.slide)
                if self.slide and key[0] == self.first
                else default_slides(mechanism)
            )
            if not slides:
                self.notify({**about, "said": ""})
                return
            page = written(slider_patches(mechanism, slides, step, before_assembly))
            if len(page.encode("utf-8")) > LARGEST:
                raise VfifeError("with its sliders the page would be too large")
            self._keep(key, True, page)
            self.notify(about)
        except Superseded:
            return
        except (VfifeError, ValueError) as error:
            self.notify({**about, "said": f"No sliders: {str(error).splitlines()[0]}"})

    def close(self) -> None:
        """End the thread, at the next position at the latest."""
        with self.changed:
            self.closed = True
            self.changed.notify_all()


@lru_cache(maxsize=64)
def drawing(name: str) -> bytes:
    """A mechanism of the gallery at its start, as SVG; for one thread at a time. Raises LookupError for a
    name that it has not.
    """
    from ...plots import at_start
    from ...plots.notebook import svg

    if name not in gallery.__all__:
        raise LookupError(name)
    return svg(at_start(getattr(gallery, name)()), name)

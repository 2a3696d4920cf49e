"""Pages of models: at once the running mechanism; its sliders follow when all their positions are
assembled.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

from ... import gallery
from ...errors import VfifeError
from ...modelfile import load
from ..page.page import LARGEST, live_page, page_with_sliders
from ..page.patches import slider_patches
from ..page.sliders import default_slides, parse_slides
from .documents import Document

Key = tuple[str, int]  # identity and version of a document
CACHED = 12  # pages
PAUSE = 0.5  # s, longest time for which sliders wait for a page in progress


class Superseded(BaseException):
    """Ends the assembly of sliders of a model that has changed. Derived from BaseException, so that handlers
    of model errors do not catch it.
    """


class Pages:
    """Cache and maker of pages; ``notify`` sends events to browsers. A background thread assembles sliders
    and yields to requests for pages.
    """

    def __init__(
        self,
        notify: Callable[[dict[str, Any]], None],
        slide: Sequence[str] | None = None,
        sliders: bool = True,
    ) -> None:
        self.notify, self.slide, self.sliders = notify, slide, sliders
        self.first: str | None = None  # the document to which --slide applies
        self.cache: OrderedDict[tuple[Key, bool], str] = OrderedDict()
        self.queue: OrderedDict[str, Document] = OrderedDict()
        self.current: Key | None = None
        self.superseded = False  # whether a document was requested after the present sliders were begun
        # ``building`` is held while a page is made; ``changed`` guards the queues and wakes the threads.
        self.building, self.changed, self.closed = threading.Lock(), threading.Condition(), False
        self.prepared: dict[str, Document] = {}  # documents whose page is made before a browser requests it
        for work, name in ((self._work, "sliders"), (self._make_ahead, "pages")):
            threading.Thread(target=work, name=name, daemon=True).start()

    def page(self, document: Document, full: bool = False) -> str:
        """Return the page of a document, with sliders if ``full`` and if they are ready. Raises VfifeError if
        the mechanism cannot run.
        """
        key = document.id, document.version
        if full and (key, True) in self.cache:
            return self.cache[key, True]
        with self.building:
            # The version is read again: of several changes during the wait only the last needs a page.
            key = document.id, document.version
            if (key, False) not in self.cache:
                self._keep(key, False, live_page(document.mechanism, [], document.its_step))
        self._want(document, key)
        return self.cache[key, False]

    def ahead(self, document: Document) -> None:
        """Make the page of a changed document before browsers request it; earlier orders for it are
        dropped.
        """
        with self.changed:
            self.prepared[document.id] = document
            self.changed.notify_all()

    def _make_ahead(self) -> None:
        """Make ordered pages one after the other; loop of the only thread that does."""
        while True:
            with self.changed:
                while not self.prepared and not self.closed:
                    self.changed.wait()
                if self.closed:
                    return
                _, document = self.prepared.popitem()
            with suppress(VfifeError, ValueError, ArithmeticError):  # raised again by the browser's request
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
            # The document requested last goes first, because somebody looks at it now. Assemblies made so far
            # are lost; keeping them would cost memory for documents that may never be opened again.
            if self.superseded:
                with self.changed:
                    self.queue.setdefault(document.id, document)
                    self.queue.move_to_end(document.id, last=False)
                raise Superseded
            # Waits while a page is being made: a page takes a fraction of a second, sliders up to minutes.
            if self.building.acquire(timeout=PAUSE):
                self.building.release()

        event = {"kind": "sliders", "id": key[0], "version": key[1]}
        try:
            slides = (
                parse_slides(mechanism, self.slide)
                if self.slide and key[0] == self.first
                else default_slides(mechanism)
            )
            if not slides:
                self.notify({**event, "said": ""})
                return
            page = page_with_sliders(slider_patches(mechanism, slides, step, before_assembly))
            if len(page.encode("utf-8")) > LARGEST:
                raise VfifeError("with its sliders the page would be too large")
            self._keep(key, True, page)
            self.notify(event)
        except Superseded:
            return
        except (VfifeError, ValueError) as error:
            self.notify({**event, "said": f"No sliders: {str(error).splitlines()[0]}"})

    def close(self) -> None:
        """End the threads, at the next position of a slider at the latest."""
        with self.changed:
            self.closed = True
            self.changed.notify_all()


@lru_cache(maxsize=64)
def drawing(name: str, path: Path | None = None, changed: int = 0) -> bytes:
    """Return a mechanism of the gallery, or of a model file, at its start as SVG; matplotlib allows one
    thread at a time. ``changed``: when the file was changed (ns), so that the drawing is made anew then.

    Raises LookupError for an unknown name, VfifeError for a file that cannot be drawn.
    """
    from ...plots import at_start
    from ...plots.notebook import svg

    if path is None and name not in gallery.__all__:
        raise LookupError(name)
    return svg(at_start(getattr(gallery, name)() if path is None else load(path)), name)

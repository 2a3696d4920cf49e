"""Requests of browsers to a session, and the events that the session sends to all of them."""

from __future__ import annotations

import asyncio
import json
import re
import subprocess
import sys
import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from ..sketch.operations import apply
from ..sketch.sketch import sketch
from .documents import Conflict, Document, Json, Shelf, text_in
from .pages import Pages

INTERVAL = 0.2  # s between two checks of the files
# Limit of simultaneous browsers. Each holds at most one event per kind and document, and system buffers.
MOST_BROWSERS = 64
# The command line in a process. Called so, it names itself "vfife" in the commands that it proposes.
COMMAND = "from vfife.__main__ import main; main()"
PROGRESS = re.compile(r" *\d+ % ")  # begins a line on the progress of a run
Key = tuple[str, str]


class Mailbox:
    """Events that a browser has not received yet. An event replaces an earlier one of the same kind and
    document, so that a slow browser holds few.
    """

    def __init__(self) -> None:
        self.events: OrderedDict[Key, str] = OrderedDict()
        self.filled = asyncio.Event()

    def put(self, key: Key, text: str) -> None:
        """Add an event; called in the thread of the event loop."""
        self.events[key] = text
        self.events.move_to_end(key)
        self.filled.set()

    async def take(self, seconds: float) -> tuple[Key, str]:
        """Return the oldest event, or wait for one. Raises TimeoutError after ``seconds``."""
        if not self.events:
            self.filled.clear()
            await asyncio.wait_for(self.filled.wait(), seconds)
        return self.events.popitem(last=False)


def text_of(event: dict[str, Any]) -> tuple[Key, str]:
    """Return the kind and document of an event, and its text, which all browsers share."""
    key = str(event["kind"]), str(event.get("id", ""))
    return key, f"data: {json.dumps(event, ensure_ascii=False)}\n\n"


class Runs:
    """Runs of saved models in processes, at most one for each model; ``notify`` is called when one ends."""

    def __init__(self, notify: Callable[[dict[str, Any]], None], folder: Path, options: list[str]) -> None:
        self.notify, self.folder, self.options = notify, folder, options
        self.processes: dict[str, subprocess.Popen[str]] = {}

    def begin(self, document: Document) -> None:
        """Run the file of a document. Raises Conflict while a run of it is in progress."""
        process = self.processes.get(document.id)
        if process is not None and process.poll() is None:
            raise Conflict("this model is being run; wait for its end")
        command = [sys.executable, "-c", COMMAND, "run", str(document.path), *self.options]
        pipe = subprocess.PIPE
        process = subprocess.Popen(
            command, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=pipe, stderr=subprocess.STDOUT,
            text=True, encoding="utf-8", start_new_session=True,
        )  # fmt: skip
        self.processes[document.id] = process
        threading.Thread(target=self._wait, args=(document.id, process), daemon=True).start()

    def _wait(self, identity: str, process: subprocess.Popen[str]) -> None:
        """Report the progress of a run, line by line, and its answer at its end."""
        lines = []
        for line in process.stdout or ():
            if PROGRESS.match(line):
                self.notify({"kind": "progress", "id": identity, "said": line.strip()})
            else:
                lines.append(line)
        code = process.wait()
        self.notify({"kind": "run", "id": identity, "code": code, "said": "".join(lines).strip()})

    def stop(self, identity: str) -> None:
        """End a run as Ctrl-C does, which keeps its outputs."""
        process = self.processes.get(identity)
        if process is not None and process.poll() is None:
            process.send_signal(2)

    def close(self) -> None:
        """End all runs."""
        for identity in self.processes:
            self.stop(identity)


class Session:
    """Open documents, their pages and runs; every change is sent to all browsers."""

    def __init__(
        self,
        folder: Path,
        slide: Sequence[str] | None = None,
        sliders: bool = True,
        options: Sequence[str] = (),
    ) -> None:
        self.shelf = Shelf(folder)
        self.pages = Pages(self.tell, slide, sliders)
        self.runs = Runs(self.tell, self.shelf.folder, list(options))
        self.lock = threading.RLock()
        self.drawing = asyncio.Lock()  # matplotlib draws for one thread at a time
        self.listeners: set[Mailbox] = set()
        self.loop: asyncio.AbstractEventLoop | None = None

    # ------------------------------------------------------------------------------------------------ telling

    def tell(self, event: Json) -> None:
        """Send an event to all browsers, from any thread."""
        if self.loop is not None:
            with suppress(RuntimeError):  # the loop has been closed
                self.loop.call_soon_threadsafe(self._put, event)

    def _put(self, event: Json) -> None:
        key, text = text_of(event)
        for mailbox in self.listeners:
            mailbox.put(key, text)

    async def watch(self) -> None:
        """Check the files of open documents every ``INTERVAL`` seconds until the session ends."""
        self.loop = asyncio.get_running_loop()
        while True:
            await asyncio.sleep(INTERVAL)
            await asyncio.to_thread(self.look)

    def look(self) -> None:
        """Check the files of open documents once."""
        for document in list(self.shelf.documents.values()):
            # Read without the lock, so that a slow disk does not delay requests. follow() discards the
            # observation if the document was saved in between.
            look = document.look()
            with self.lock:
                change = document.follow(look)
            if change == "gone":
                name = document.path.name if document.path else document.name
                self.tell(
                    {
                        "kind": "gone",
                        "id": document.id,
                        "said": f"{name} was deleted. Its text stays here; Save writes it again.",
                    }
                )
            elif change is not None:
                self.tell({"kind": "model", **document.json(), "by": "file"})

    # ------------------------------------------------------------------------------------------------- asking

    def open(self, body: Json) -> Json:
        """Open a mechanism of the gallery, a model file of the folder, or a text. Raises LookupError and
        ModelError.
        """
        with self.lock:
            if "gallery" in body:
                document = self.shelf.from_gallery(text_in(body, "gallery"))
            elif "file" in body:
                document = self.shelf.from_folder(text_in(body, "file"))
            else:
                document = self.shelf.from_text(text_in(body, "name"), text_in(body, "text"))
            return document.json()

    def change(self, identity: str, change: Callable[[Document], object], ahead: bool = True) -> Json:
        """Change a document and inform all browsers; make its page ``ahead`` of their requests. Raises
        LookupError, Conflict and ModelError.
        """
        with self.lock:
            document = self.shelf[identity]
            previous = document.version, document.saved, document.faults
            change(document)
            state = document.json()
            # Every browser gets the event, also the one that made the change; the version tells it whether it
            # shows this state already.
            if (document.version, document.saved, document.faults) != previous:
                self.tell({"kind": "model", **state, "by": "browser"})
            if ahead and document.version != previous[0]:
                self.pages.ahead(document)
        return state

    def sketch(self, identity: str, body: Json) -> Json:
        """Return the drawing of a text of a document, after an operation if one is named, and the text then.

        The document does not change; a browser sends the text back to keep it. Raises LookupError and
        ModelError.
        """
        document = self.shelf[identity]
        text = text_in(body, "text") if "text" in body else document.text
        document.refuse_large(text)
        file = str(document.path) if document.path else None
        if "operation" in body:
            arguments = body["arguments"]
            if not isinstance(arguments, dict):
                raise TypeError("arguments are to be a table of names and values")
            text = apply(text, text_in(body, "operation"), arguments, file)
        return {"text": text, **sketch(text, file)}

    def save(self, identity: str, name: str | None) -> Json:
        """Save a document, under a new name if given. Raises Conflict, OSError."""
        return self.change(identity, lambda document: document.save(self.shelf.place(name) if name else None))

    def run(self, identity: str) -> None:
        """Run a saved document. Raises Conflict."""
        document = self.shelf[identity]
        if not document.saved:
            raise Conflict("save the model first: its file is run")
        self.runs.begin(document)

    def close(self) -> None:
        """Inform browsers of the end, and end pages and runs in progress."""
        self.tell({"kind": "end"})
        self.pages.close()
        self.runs.close()

    @property
    def unsaved(self) -> list[str]:
        """Names of documents with unsaved changes."""
        return [
            document.name
            for document in self.shelf.documents.values()
            if document.text != document.opened and not document.saved
        ]

"""Events on their way to a browser: of each kind and document only the last one waits, so that a browser which does not read costs little."""

from __future__ import annotations

import asyncio
import json
from collections import OrderedDict
from typing import Any

MOST_BROWSERS = 64  # that listen at once; each may hold one event of each kind and document, and what the system buffers
Key = tuple[str, str]


class Mailbox:
    """The events that a browser has not got yet. An event supersedes the one of the same kind and document before it."""

    def __init__(self) -> None:
        self.events: OrderedDict[Key, str] = OrderedDict()
        self.filled = asyncio.Event()

    def put(self, key: Key, text: str) -> None:
        """Add an event; in the loop's thread."""
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
    """What an event is about, and its text, which all browsers share."""
    return (str(event["kind"]), str(event.get("id", ""))), f"data: {json.dumps(event, ensure_ascii=False)}\n\n"

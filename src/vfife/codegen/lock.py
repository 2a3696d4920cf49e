"""One thread at a time reads, writes and compiles code: Python 3.11 loses count when two parse or compile syntax trees at once."""

from __future__ import annotations

import threading

WRITING = threading.RLock()

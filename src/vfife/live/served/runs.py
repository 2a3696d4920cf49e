"""Runs that are asked for in a browser: ``vfife run`` in a process of its own, whose sentences are told."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .documents import Conflict, Document


class Runs:
    """Runs of saved models, one at a time each; ``told`` is called at their end."""

    def __init__(self, told: Callable[[dict[str, Any]], None], folder: Path, options: list[str]) -> None:
        self.told, self.folder, self.options = told, folder, options
        self.processes: dict[str, subprocess.Popen[str]] = {}

    def begin(self, document: Document) -> None:
        """Runs the file of a document. Raises Conflict where it is being run."""
        process = self.processes.get(document.id)
        if process is not None and process.poll() is None:
            raise Conflict("this model is being run; wait for its end")
        command = [sys.executable, "-m", "vfife", "run", str(document.path), *self.options]
        pipe = subprocess.PIPE
        process = subprocess.Popen(
            command, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=pipe, stderr=subprocess.STDOUT, text=True, encoding="utf-8",
            start_new_session=True,
        )  # fmt: skip
        self.processes[document.id] = process
        threading.Thread(target=self._wait, args=(document.id, process), daemon=True).start()

    def _wait(self, which: str, process: subprocess.Popen[str]) -> None:
        said, _ = process.communicate()
        self.told({"kind": "run", "id": which, "code": process.returncode, "said": said.strip()})

    def stop(self, which: str) -> None:
        """Ends a run as Ctrl-C does: what was computed is kept."""
        process = self.processes.get(which)
        if process is not None and process.poll() is None:
            process.send_signal(2)

    def close(self) -> None:
        """Ends all of them."""
        for which in self.processes:
            self.stop(which)

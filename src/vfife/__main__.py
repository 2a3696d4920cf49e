"""``python -m vfife``."""

from __future__ import annotations

from .cli import app

app(prog_name="vfife")

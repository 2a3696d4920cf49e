"""``python -m vfife``."""

from __future__ import annotations

from .cli.app import app

app(prog_name="vfife")

"""Pages in which a mechanism runs: one file with its step as JavaScript, its numbers, and what draws them; no server, no network."""

from __future__ import annotations

from .page import live_page
from .page_model import model_of
from .sliders import Slide, asked_slides, default_slides

__all__ = ["Slide", "asked_slides", "default_slides", "live_page", "model_of"]

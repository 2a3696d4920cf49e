"""Pages that run a mechanism in a browser: one file with the step as JavaScript, its numbers and the scripts
that draw; no server and no network.
"""

from __future__ import annotations

from .page.page import live_page
from .page.page_model import model_of
from .page.sliders import Slide, default_slides, parse_slides

__all__ = ["Slide", "default_slides", "live_page", "model_of", "parse_slides"]

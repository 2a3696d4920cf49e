"""Model files: TOML text to a mechanism and back. A file holds names and numbers; it can never name code to
load.
"""

from __future__ import annotations

from .read import load, loads
from .write import dump

__all__ = ["dump", "load", "loads"]

"""Model files: TOML text to mechanism and back. A file contains names and numbers and can never name code to
load.
"""

from __future__ import annotations

from .read import load, loads
from .write import dump

__all__ = ["dump", "load", "loads"]

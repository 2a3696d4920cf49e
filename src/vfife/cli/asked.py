"""What a command was asked for, and what of it is there already: next to nothing is loaded to know it."""

from __future__ import annotations


class Asked:
    """Whether one object on standard output is asked for (``--json``), and whether it is printed."""

    def __init__(self) -> None:
        self.as_json, self.printed = False, False


ASKED = Asked()

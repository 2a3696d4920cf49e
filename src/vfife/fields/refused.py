"""What a field says of a value that it does not take."""

from __future__ import annotations


class Refused(ValueError):
    """A value that a field does not take: what it is ("negative"), the value as written, what is allowed, what to do."""

    def __init__(self, what: str, value: str = "", limit: str = "", remedy: str = "") -> None:
        super().__init__(what)
        self.what, self.value, self.limit, self.remedy = what, value, limit, remedy

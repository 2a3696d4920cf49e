"""What a page is made of: items with parameters, pictures, tables and verdicts. Plain data, no libraries."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from vfife.report.document import Table

Origin = Literal["stated", "inferred", "chosen"]
# "main", "second" ... "fifth", "ideal", "paper", "circle", "faint", or a number: that of a colour in a long
# row
Style = str


@dataclass(frozen=True)
class Parameter:
    """A parameter of an item: its value in words, and whether the paper states it, it is inferred from Table
    3, or chosen here.
    """

    name: str
    value: str
    origin: Origin
    where: str


@dataclass(frozen=True)
class Line:
    """A line of a picture, or marks where ``dots`` is set; ``style`` says its part in it. Axes may be numpy
    arrays.
    """

    x: Any
    y: Any
    label: str = ""
    style: Style = "main"
    dots: bool = False


@dataclass(frozen=True)
class Ribbon:
    """The area between two curves over the same abscissa, in the style of the line within it."""

    x: Any
    low: Any
    high: Any
    style: Style = "main"


@dataclass(frozen=True)
class Band:
    """A shaded stretch of the abscissa."""

    first: float
    last: float
    label: str = ""


@dataclass(frozen=True)
class Panel:
    """One pair of axes."""

    title: str
    x: str
    y: str
    lines: Sequence[Line]
    bands: Sequence[Band] = ()
    equal: bool = False
    logarithmic: str = ""
    ribbons: Sequence[Ribbon] = ()


@dataclass(frozen=True)
class Chart:
    """A picture: panels in rows of ``columns``."""

    name: str
    caption: str
    panels: Sequence[Panel]
    columns: int = 3


@dataclass(frozen=True)
class Verdict:
    """A statement of the paper in our words, whether it holds here (None: cannot be told), and the numbers it
    is judged by.
    """

    statement: str
    holds: bool | None
    numbers: str

    @property
    def word(self) -> str:
        """``true``, ``false`` or ``open``."""
        return {True: "true", False: "false", None: "open"}[self.holds]


@dataclass
class Item:
    """A figure, a table or a question, computed."""

    name: str
    title: str
    text: Sequence[str] = ()
    parameters: Sequence[Parameter] = ()
    charts: Sequence[Chart] = ()
    tables: Sequence[Table] = ()
    verdicts: Sequence[Verdict] = ()
    data: dict[str, Any] = field(default_factory=dict)

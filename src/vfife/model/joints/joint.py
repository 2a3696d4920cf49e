"""What all joints share."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from ...errors import Fault
from ...schema import Text, described
from ..drawing.strokes import Extent, JointView, Label, Stroke, under
from ..kind import Kind
from ..rows import Coincide, Row, place_row

Point = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Joint(Kind):
    """Two pins in one place: ``bearing`` and ``journal`` are ``body.pin`` or ``ground.point``."""

    name: str
    bearing: str = described(Text("pin"), 'the bearing side, "body.pin" or "ground.point"')
    journal: str = described(Text("pin"), 'the journal side, "body.pin" or "ground.point"')

    registry: ClassVar[dict[str, type[Joint]]] = {}
    refits: ClassVar[bool] = (
        # whether its numbers reach nothing but the record of its one contact, journals being centred at the
        # start
        False
    )

    @property
    def sides(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """(body, pin) of the bearing and of the journal."""
        bearing, journal = self.bearing.partition("."), self.journal.partition(".")
        return (bearing[0], bearing[2]), (journal[0], journal[2])

    def conflicts(self) -> Iterator[Fault]:
        """Sizes that do not go together; of what is not known (None) nothing is said."""
        yield from ()

    def rows(self) -> tuple[Row, ...]:
        """What the joint holds; with play: what it would hold without."""
        without = self.ideal()
        return () if without is None or without is self else without.rows()

    def ideal(self) -> Joint | None:
        """The joint without play, itself where it has none; None where nothing is left of it then."""
        return self

    @property
    def revolves(self) -> bool:
        """Whether two bodies turn freely about its pin."""
        return self.rows() == (Coincide(),)

    @property
    def rank(self) -> int:
        """Which joints hang a body first when a mechanism is put together: pins (0) before guides (1) before
        what only touches (2).
        """
        held = place_row(self.rows())
        return 2 if held is None else 0 if isinstance(held, Coincide) else 1

    @property
    def first_place(self) -> Point:
        """Where the journal's pin stands before the mechanism is closed, seen from the bearing's in the frame
        of its body (m).
        """
        return 0.0, 0.0

    @property
    def words(self) -> str:
        """What it is, in a word or two."""
        return self.kind

    def strokes(self, view: JointView) -> list[Stroke]:
        """How it is drawn."""
        return []

    def label(self, view: JointView) -> Label:
        """Where its name stands."""
        return under(view)

    @property
    def drawn(self) -> Extent:
        """What a drawing must hold of it."""
        return Extent()

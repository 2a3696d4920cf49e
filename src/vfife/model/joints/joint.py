"""Base of all joints."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import ClassVar

from ...errors import Fault
from ...schema import Text, described
from ..drawing.strokes import Extent, JointView, Label, Stroke, name_place
from ..kind import Kind
from ..rows import Coincide, Row, place_row

Point = tuple[float, float]


@lru_cache(maxsize=4096)
def _sides(bearing: str, journal: str) -> tuple[tuple[str, str], tuple[str, str]]:
    """Return body and pin of both sides; known ones, because every stage of an assembly asks for them."""
    (body, _, pin), (opposite, _, end) = bearing.partition("."), journal.partition(".")
    return (body, pin), (opposite, end)


@dataclass(frozen=True, kw_only=True)
class Joint(Kind):
    """Base of all joints between two pins: ``name`` is unique within the mechanism, ``bearing`` and
    ``journal`` are ``body.pin`` or ``ground.point``.
    """

    name: str
    bearing: str = described(Text("pin"), 'the bearing side, "body.pin" or "ground.point"')
    journal: str = described(Text("pin"), 'the journal side, "body.pin" or "ground.point"')

    registry: ClassVar[dict[str, type[Joint]]] = {}
    # Whether its sizes enter only the record of its one contact, so that another size needs no new assembly.
    # This holds while journals start centred: a seated journal starts at a place that depends on them.
    refits: ClassVar[bool] = False

    @property
    def sides(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """(body, pin) of the bearing and of the journal."""
        return _sides(self.bearing, self.journal)

    def conflicts(self) -> Iterator[Fault]:
        """Yield a fault for each pair of sizes that contradict each other; unknown sizes (None) are
        skipped.
        """
        yield from ()

    def rows(self) -> tuple[Row, ...]:
        """Return the constraint rows; of a joint with clearance, those of its ideal joint."""
        without = self.reference
        return () if without is None or without is self else without.rows()

    def ideal(self) -> Joint | None:
        """Return the joint without clearance, which may be the joint itself; None if nothing remains."""
        return self

    @cached_property
    def reference(self) -> Joint | None:
        """The joint of :meth:`ideal`, one object for all mechanisms with this joint."""
        return self.ideal()

    @property
    def revolves(self) -> bool:
        """Whether two bodies turn freely about its pin."""
        return self.rows() == (Coincide(),)

    @property
    def rank(self) -> int:
        """Order in which joints place bodies when a mechanism is assembled: pins (0), guides (1), contacts
        (2).
        """
        row = place_row(self.rows())
        return 2 if row is None else 0 if isinstance(row, Coincide) else 1

    @property
    def first_place(self) -> Point:
        """First guess of the journal's pin (m), from the bearing's pin in the frame of its body."""
        return 0.0, 0.0

    @property
    def words(self) -> str:
        """Name of the joint for readers."""
        return self.kind

    def strokes(self, view: JointView) -> list[Stroke]:
        """Return the strokes that draw the joint in the pose ``view``."""
        return []

    def label(self, view: JointView) -> Label:
        """Return the place of the joint's name in the drawing ``view``."""
        return name_place(view)

    @property
    def drawn(self) -> Extent:
        """Extent that a drawing must leave for the joint."""
        return Extent()

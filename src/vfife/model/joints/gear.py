"""Gears and belts."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ...numerics.scalar import hypot
from ...schema import Text, described, quantity
from ..drawing.strokes import Array, Curve, PairView, Stroke, ring, tangent
from ..rows import Row, Turn


@dataclass(frozen=True, kw_only=True)
class Gear:
    """A pair of gears or a belt with a unique ``name`` between two bodies: ``second`` turns by ``ratio``
    times the angle of ``first``.

    The ratio is negative for external gears (minus teeth of the first over teeth of the second) and positive
    for belts and internal gears. Angles are relative to the ``carrier``, the body on which both wheels turn
    (Willis), which takes the remaining moment. By default the carrier follows from the pins of the wheels:
    the arm of a planet, else the ground. One of the two bodies may be the ground: a fixed sun or ring.

    A gear carries a moment and no force: forces between teeth, and pulls of a belt, are not modelled, and the
    forces of the joints of its wheels lack them. ``moment.max`` is that on ``second``.
    """

    name: str
    first: str = described(Text("body"), "a body")
    second: str = described(
        Text("body"),
        "another body, which turns by ratio times the angle of the first, both seen from the carrier",
    )
    ratio: float = quantity(
        "1", "negative for external gears (- teeth of the first / teeth of the second), positive for belts"
    )

    carrier: str | None = described(
        Text("body"), "the body on which both turn; found by their pins if left out", None
    )

    def rows(self) -> tuple[Row, ...]:
        """Return the row that couples the two angles."""
        return (Turn(self.ratio),)

    @property
    def words(self) -> str:
        """Name of the gear for readers."""
        return f"gear, ratio {self.ratio:.6g}"

    def wheels(self, view: PairView) -> tuple[tuple[Array, float], tuple[Array, float]]:
        """Return the centre and radius (m) of both wheels in the pose ``view``, with r_1 = |ratio| r_2;
        external gears touch.
        """

        distance, ratio = hypot(*(view.second - view.first)) or 0.2 * view.size, abs(self.ratio)
        second = distance / (1.0 + ratio) if self.ratio < 0.0 else 0.3 * distance / max(1.0, ratio)
        return (view.first, ratio * second), (view.second, second)

    def strokes(self, view: PairView) -> list[Stroke]:
        """Return the pitch circles of external gears, or wheels with a belt for a positive ratio, in the pose
        ``view``.
        """
        first, second = self.wheels(view)
        strokes: list[Stroke] = [
            ring(centre, radius, colour=colour, width=1.6, dashes="-." if self.ratio < 0.0 else "-", rank=4.0)
            for (centre, radius), colour in ((first, "bearing"), (second, "journal"))
        ]
        if self.ratio < 0.0:
            return [*strokes, Curve(np.zeros((0, 2)), width=1.4, dashes="-.", sign="gears, pitch circles")]
        belt = [Curve(tangent(first, second, side), "grey", 1.4, 4.0) for side in (1.0, -1.0)]
        return [*strokes, *belt, Curve(np.zeros((0, 2)), width=1.4, sign="wheels with a belt")]


def gear_cautions(gears: Iterable[str]) -> tuple[str, ...]:
    """Return a sentence on the forces that gears, by name, do not have; none without gears."""
    names = list(gears)
    if not names:
        return ()
    word = f"Gear {names[0]} couples" if len(names) == 1 else f"Gears {', '.join(names)} couple"
    return (
        f"{word} angles by a moment M. Forces between teeth, or of a belt, are not modelled: the forces in"
        " the bearings of geared shafts lack them. Estimate: F = M / r, where r is the pitch radius of the"
        " second wheel.",
    )

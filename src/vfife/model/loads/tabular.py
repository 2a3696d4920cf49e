"""Loads that go by a table: over time, a crank's angle, or a travel along a guide and its speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...fields import Choice, Many, Measure, Switch, described, quantity
from ..polynomials import Polynomials, constant, moved
from ..tabulated import INTERPOLATIONS, JOINING, Interpolation, closes, held, repeated, table, two_ways, whole_turns
from .load import OVER, Load, Over

OPEN = 1e-3  # of the largest value: by how much two ways may differ where they meet
Values = float | Sequence[float] | None


@dataclass(frozen=True, kw_only=True)
class Tabular(Load):
    """A load whose size is one number, or a table over ``times``, ``angles``, ``travels`` or ``speeds``.

    ``angles`` are those of the body ``crank``, as it lies in space, less ``zero_angle``; ``travels`` and ``speeds`` are those of a guide's
    journal from its bearing, less ``zero_travel``. Beyond its ends a table keeps its end values, unless it is to ``repeat``, as one over whole
    turns does by itself.
    """

    times: tuple[float, ...] | None = described(Many(Measure("s")), "times of a table's values, ascending", None)
    angles: tuple[float, ...] | None = described(Many(Measure("rad")), "angles of the crank at a table's values, ascending", None)
    travels: tuple[float, ...] | None = described(
        Many(Measure("m")), "places of the journal along the guide, from the bearing's pin, at a table's values, ascending", None
    )
    speeds: tuple[float, ...] | None = described(Many(Measure("m/s")), "speeds of the journal along the guide at a table's values, ascending", None)
    zero_angle: float = quantity("rad", "angle of the crank at which the table has its 0", 0.0)
    zero_travel: float = quantity("m", "place along the guide at which the table has its 0", 0.0)
    repeat: bool | None = described(
        Switch(), "true: a table over times or angles repeats itself; false: it keeps its end values; left out: one over whole turns repeats", None
    )
    interpolation: Interpolation = described(Choice(INTERPOLATIONS), JOINING, "monotone")

    @property
    def keys(self) -> tuple[str, str]:
        """The keys of its values, and of those of the way back."""
        raise NotImplementedError

    @property
    def axis(self) -> str:
        """The key of the table's places; nothing where there is no table."""
        return next((key for key in OVER if getattr(self, key) is not None), "")

    @property
    def over(self) -> Over:
        """What its function depends on."""
        return OVER.get(self.axis, "time")

    @property
    def steady(self) -> bool:
        """Whether it does not depend on time."""
        return self.axis != "times"

    @property
    def repeats(self) -> bool:
        """Whether its table repeats itself."""
        if self.repeat is None:
            values, angles = self.values, self.angles if self.axis == "angles" else None
            return angles is not None and isinstance(values, Sequence) and whole_turns(angles) and closes(values)
        return bool(self.repeat) and self.axis in ("times", "angles")

    @property
    def values(self) -> Values:
        """One value, or those of the table."""
        raise NotImplementedError

    @property
    def values_back(self) -> Values:
        """Those of the way back where they differ; None else."""
        return None

    @property
    def by(self) -> str:
        """By what its table goes, in words; nothing where it has none."""
        ways = "" if self.values_back is None else ", with a way back"
        return f", by {self.over}{ways}{', repeated' if self.repeats else ''}" if self.axis else ""

    def cautions(self) -> tuple[str, ...]:
        """Sentences on two ways whose values do not meet where the way turns."""
        out, back, places = self.values, self.values_back, self.travels
        if not isinstance(out, Sequence) or not isinstance(back, Sequence) or places is None:
            return ()
        largest = max(max(map(abs, out)), max(map(abs, back)))
        open_ends = [k for k in (0, -1) if abs(out[k] - back[k]) > OPEN * largest]
        return tuple(
            f"The load {self.name} leaps where the way turns: at {places[k]:g} m its table has {out[k]:g} for the way out and {back[k]:g} for the "
            "way back. A gas has one pressure there: give both the same value, unless a leap is meant."
            for k in open_ends
        )

    def course(self) -> tuple[Polynomials, float]:
        """The function that its table is, or a constant, and the gap (m) of a table with two ways."""
        values, back, gap = self.values, self.values_back, 0.0
        if not self.axis or not isinstance(values, Sequence):
            return constant(float(values if isinstance(values, int | float) else 1.0)), gap
        places, zero = getattr(self, self.axis), {"angles": self.zero_angle, "travels": self.zero_travel}.get(self.axis, 0.0)
        out = table(places, values, self.interpolation, repeated=self.repeats)
        if isinstance(back, Sequence):
            function, gap = two_ways(out, table(places, back, self.interpolation))
        else:
            function = (repeated if self.repeats else held)(out)
        return moved(function, zero), gap

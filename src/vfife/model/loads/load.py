"""Base of all loads: given by a number, a table or an expression over time, a crank's angle, or the travel or
speed along a guide.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import ClassVar, Literal

from ...errors import Fault
from ...schema import Choice, FreeList, Measure, Switch, Text, described, quantity
from ..geometry.expression import VARIABLES, parse
from ..geometry.polynomials import Polynomials, constant, moved
from ..geometry.tabulated import (
    INTERPOLATIONS,
    JOINING,
    Interpolation,
    Pieces,
    extended,
    full_turns,
    repeated,
    sampled,
    table,
    two_ways,
)
from ..joints import Joint
from ..kind import Kind

Argument = Literal["time", "angle", "travel", "speed"]
Triple = tuple[float, float, float]
# Argument of a table, by the field with its places.
ARGUMENTS: dict[str, Argument] = {"times": "time", "angles": "angle", "travels": "travel", "speeds": "speed"}
NEARLY_A_TURN = 0.9  # of a turn: a measured diagram that ends some degrees before its last value
OPEN = 1e-3  # of the largest value: by how much two ways may differ where they meet
Values = float | Sequence[float] | None


@dataclass(frozen=True)
class Push:
    """Force (N, N) and moment (N m) of a load whose function is 1, on ``body`` at its ``pin``, or on the body
    as a whole if ``pin`` is empty.

    With ``follow`` the force turns with the body, else it is fixed in space. ``aligned`` names another body
    in whose frame at the start the direction is given; the force then turns with the loaded body.
    """

    body: str
    pin: str
    acts: Triple
    follow: bool = False
    aligned: str = ""


@dataclass(frozen=True, kw_only=True)
class Load(Kind):
    """Base of all loads with a unique ``name``: forces and moments on bodies, multiplied by a number, a table
    over ``times``, ``angles``, ``travels`` or ``speeds``, or an ``expression``.

    ``angles`` are those of the body ``crank`` in space, minus ``zero_angle``; ``travels`` and ``speeds`` are
    those of a guide's journal relative to its bearing, travels minus ``zero_travel``. Beyond its ends a table
    keeps its end values unless it repeats: with ``repeat``, or by default over whole turns.
    """

    name: str
    crank: str = described(
        Text("body"), "body whose angle the load depends on; the driven one that revolves if left out", ""
    )
    slider: str = described(
        Text("joint"), "a joint with a guide, whose travel or speed the load depends on", ""
    )
    times: tuple[float, ...] | None = described(
        FreeList(Measure("s")), "times of a table's values, ascending", None
    )
    angles: tuple[float, ...] | None = described(
        FreeList(Measure("rad")), "angles of the crank at a table's values, ascending", None
    )
    travels: tuple[float, ...] | None = described(
        FreeList(Measure("m")),
        "places of the journal along the guide, from the bearing's pin, at a table's values, ascending",
        None,
    )
    speeds: tuple[float, ...] | None = described(
        FreeList(Measure("m/s")), "speeds of the journal along the guide at a table's values, ascending", None
    )
    zero_angle: float = quantity("rad", "angle of the crank at which the table has its 0", 0.0)
    zero_travel: float = quantity("m", "place along the guide at which the table has its 0", 0.0)
    repeat: bool | None = described(
        Switch(),
        "true: a table over times or angles repeats itself; false: it keeps its end values; left out: one"
        " over whole turns repeats",
        None,
    )
    interpolation: Interpolation = described(Choice(INTERPOLATIONS), JOINING, "monotone")
    expression: str = described(
        Text(),
        "the load as an expression of t, angle, x or v, from the first of the times, angles, travels or"
        " speeds to the last",
        "",
    )
    expression_back: str = described(Text(), "the same on the way back, if different", "")

    registry: ClassVar[dict[str, type[Load]]] = {}
    tabled: ClassVar[bool] = True  # a model file may have its table in a CSV file beside it
    on_guide: ClassVar[bool] = False  # whether it acts along the guide of a joint; else at a pin

    @property
    def words(self) -> str:
        """Description for readers."""
        return self.kind

    @property
    def unit(self) -> float:
        """Force (N) along a guide for a function value of 1; 1 of a load at a pin."""
        return 1.0

    @property
    def place(self) -> str:
        """Where it acts: a pin, "body.pin", or the joint along whose guide it acts."""
        return self.slider

    @property
    def measured(self) -> tuple[str, str]:
        """Unit and meaning of its function."""
        return "1", "what multiplies the load"

    def pushes(self, joints: Mapping[str, Joint]) -> tuple[Push, ...]:
        """Return the forces and moments for a function value of 1; ``joints`` are those of the mechanism, by
        name.
        """
        raise NotImplementedError

    @property
    def keys(self) -> tuple[str, str]:
        """Field names of its values and of the values of the return stroke."""
        raise NotImplementedError

    def conflicts(self) -> Iterator[Fault]:
        """Yield a fault for each pair of values that contradict each other; unknown values (None) are
        skipped.
        """
        yield from ()

    @property
    def axis(self) -> str:
        """Field name of the argument of its table or expression; "" if it has neither."""
        return (VARIABLES.get(self.variable, "") if self.expression else "") or next(
            (key for key in ARGUMENTS if getattr(self, key) is not None), ""
        )

    @property
    def variable(self) -> str:
        """Variable of its expression; "" without one, or if the expression cannot be parsed."""
        try:
            return parse(self.expression).variable
        except Fault:
            return ""

    @property
    def places(self) -> tuple[float, ...]:
        """Arguments of its table, or the range of its expression; the default for angles is one turn."""
        places: tuple[float, ...] | None = getattr(self, self.axis) if self.axis else None
        return places or ((0.0, 2.0 * math.pi) if self.axis == "angles" and self.expression else ())

    @property
    def argument(self) -> Argument:
        """Argument of its function: time (s), angle (rad), travel (m) or speed (m/s)."""
        return ARGUMENTS.get(self.axis, "time")

    @property
    def steady(self) -> bool:
        """Whether it is independent of time."""
        return self.axis != "times"

    @property
    def repeats(self) -> bool:
        """Whether its table or expression is periodic."""
        if self.repeat is not None:
            return self.repeat and self.axis in ("times", "angles")
        if self.axis != "angles" or len(self.places) < 2 or not full_turns(self.places):
            return False
        way = self.way(self.values, self.expression)
        return way is not None and way.closes

    @property
    def repeats_each_turn(self) -> bool:
        """Whether it is the same in each turn of a crank: not over time, nor over angles unless its table
        repeats with a turn or a part of it.
        """
        if self.axis != "angles":
            return self.axis != "times"
        period = self.places[-1] - self.places[0]
        count = round(2.0 * math.pi / period) if period > 0.0 else 0
        return self.repeats and count >= 1 and abs(count * period - 2.0 * math.pi) < 1e-9

    @property
    def ends(self) -> tuple[float, ...]:
        """First and last value of its table or expression; empty if it has neither."""
        way = self.way(self.values, self.expression)
        return () if way is None else way.ends

    def way(self, values: Values, expression: str, *, repeated: bool = False) -> Pieces | None:
        """Return the pieces of tabulated values or of an expression, or None for a constant.

        values: the table, or a constant
        expression: text over time, angle or travel; empty for a table
        repeated: True if the values repeat after the last one
        """
        if expression and len(self.places) > 1:
            pieces = sampled(expression, self.places[0], self.places[-1])
            return replace(
                pieces, rows=tuple((row[0] - self.ambient_pressure, *row[1:]) for row in pieces.rows)
            )
        if self.axis and isinstance(values, Sequence):
            return table(self.places, values, self.interpolation, repeated=repeated)
        return None

    @property
    def ambient_pressure(self) -> float:
        """Value that is subtracted from an expression."""
        return 0.0

    @property
    def values(self) -> Values:
        """One value, or those of the table."""
        raise NotImplementedError

    @property
    def values_back(self) -> Values:
        """Values of the return stroke if they differ, else None."""
        return None

    @property
    def by(self) -> str:
        """Description of its argument for readers; "" for a constant."""
        ways = ", with a way back" if self.values_back is not None or self.expression_back else ""
        return f", by {self.argument}{ways}{', repeated' if self.repeats else ''}" if self.axis else ""

    def cautions(self) -> tuple[str, ...]:
        """Return the sentences on a table that does not close over a turn, and on values of the two strokes
        that differ where the direction reverses.
        """
        return self._cautions

    def end_caution(self, duration: float) -> str:
        """Return the sentence on a function of time that ends before about the ``duration`` (s) of a motion;
        empty for others.
        """
        if self.axis != "times" or self.repeats or len(self.places) < 2 or self.places[-1] >= duration:
            return ""
        return (
            f"The load {self.name} is a function of time up to {self.places[-1]:.5g} s, and keeps its last"
            f" value after that, in a motion of about {duration:.3g} s. For a load that repeats, give one"
            " period and repeat = true, or an expression of the angle of a body that a driver turns (crank)."
        )

    @cached_property
    def _cautions(self) -> tuple[str, ...]:
        return (*self._open_turn(), *self._along_travel(), *self._jumps())

    def _along_travel(self) -> Iterator[str]:
        """Yield a sentence on a force along a guide whose two ways differ, and never so that the force takes
        up work, at its places and halfway between them.
        """
        if not self.on_guide or self.measured[0] != "N" or self._ways[1] is None:
            return
        middles = (0.5 * (low + high) for low, high in pairwise(self.places))
        pairs = [self.strokes_at(place) for place in (*self.places, *middles)]
        gains = [math.copysign(1.0, self.unit) * (out - back) for out, back in pairs]
        if max(gains) > OPEN * self.largest and min(gains) >= 0.0:
            out, back = ("expression", "expression_back") if self.expression else self.keys
            yield (
                f"The load {self.name} drives the machine: where its two ways differ, it acts along the"
                f" motion of {self.slider}. {out} is that of growing travel, {back} that of falling travel."
                f" A tool or friction resists: exchange {out} and {back}, or check their signs and reverse."
            )

    def _open_turn(self) -> Iterator[str]:
        """Yield a sentence on a table over nearly a turn of a crank that the next turn does not continue."""
        if self.axis != "angles" or len(self.places) < 2 or self.repeat is False or not self.ends:
            return
        first, last = (math.degrees(place) for place in (self.places[0], self.places[-1]))
        turns, end = (last - first) / 360.0, first + 360.0 * max(round((last - first) / 360.0), 1)
        table = f"The table of load {self.name}"
        if self.repeats:
            if not full_turns(self.places) and abs(turns - round(turns)) < 1.0 - NEARLY_A_TURN:
                period = f"{last - first:.5g}° of the crank"
                yield f"{table} repeats every {period}, not with each turn: let it end at {end:.5g}°."
        elif turns >= NEARLY_A_TURN:
            ends = (
                "; its ends differ, {:.6g} and {:.6g},".format(*self.ends) if full_turns(self.places) else ""
            )
            yield (
                f"{table} covers {first:.5g}° to {last:.5g}° of the crank{ends} and keeps its last value in"
                f" all later turns. For a load that repeats with each turn, let it end at {end:.5g}° with the"
                " first value; for one that does not, write repeat = false."
            )

    def _jumps(self) -> tuple[str, ...]:
        back = self.way(self.values_back, self.expression_back)
        out = None if back is None else self.way(self.values, self.expression)
        if out is None or back is None:
            return ()
        largest = max(out.largest, back.largest)
        pairs = zip((self.places[0], self.places[-1]), out.ends, back.ends, strict=True)
        remedy = (
            "A gas has one pressure there: give both the same value unless a jump is intended."
            if self.measured[0] == "Pa"
            else "Give both the same value unless a jump is intended, as where a tool lets go."
        )
        return tuple(
            f"The load {self.name} jumps where the travel reverses: at {place:g} m it is {forward:g} on the"
            f" way out and {backward:g} on the way back. {remedy}"
            for place, forward, backward in pairs
            if abs(forward - backward) > OPEN * largest
        )

    def strokes_at(self, place: float) -> tuple[float, float]:
        """Return the values of both strokes at a place of a table over travels, equal without a way back."""
        out, back = (None if function is None else function(place)[0] for function in self._strokes)
        out = self.constant if out is None else out
        return out, out if back is None else back

    @property
    def largest(self) -> float:
        """Largest absolute value of its table or expression."""
        return self._largest

    @property
    def bounds(self) -> tuple[float, float]:
        """Lowest and highest value where the pieces of its table or expression begin or end, on both ways."""
        ways = [way for way in self._ways if way is not None]
        values = [value for way in ways for value in (*(row[0] for row in way.rows), *way.ends)]
        return (min(values), max(values)) if values else (self.constant, self.constant)

    @cached_property
    def _ways(self) -> tuple[Pieces | None, Pieces | None]:
        return self.way(self.values, self.expression), self.way(self.values_back, self.expression_back)

    # Cases of a study share their loads, so both are found once.
    @cached_property
    def _strokes(self) -> tuple[Polynomials | None, ...]:
        return tuple(None if way is None else extended(way) for way in self._ways)

    @cached_property
    def _largest(self) -> float:
        return max((way.largest for way in self._ways if way is not None), default=abs(self.constant))

    def course(self) -> tuple[Polynomials, float]:
        """Return the function of its table or expression, or a constant, and the gap (m) of one with two
        strokes.
        """
        return self._course

    @cached_property
    def _course(self) -> tuple[Polynomials, float]:
        out, gap = self.way(self.values, self.expression, repeated=self.repeats), 0.0
        if out is None:
            return constant(self.constant), gap
        zero = {"angles": self.zero_angle, "travels": self.zero_travel}.get(self.axis, 0.0)
        back = self.way(self.values_back, self.expression_back)
        if back is not None:
            function, gap = two_ways(out, back)
        else:
            function = (repeated if self.repeats else extended)(out)
        return moved(function, zero), gap

    @property
    def constant(self) -> float:
        """Value of a load that depends on nothing."""
        if self.expression:
            return parse(self.expression).constant - self.ambient_pressure
        return float(self.values) if isinstance(self.values, int | float) else 1.0

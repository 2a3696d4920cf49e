"""The force along a guide, such as that of gas in a cylinder."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from ...errors import Fault
from ...schema import Measure, Switch, Text, described, quantity
from ..joints import Joint
from ..rows import Guided, place_row
from .load import Load, Push, Values


@dataclass(frozen=True, kw_only=True)
class GuideForce(Load):
    """A force along the guide of the joint ``slider`` on its journal, with its opposite on the bearing: of a
    piston, a spindle or a nonlinear spring.

    It is a ``force`` (N), or an absolute ``pressure`` (Pa) above ``ambient`` on the area pi bore^2/4 of a
    ``bore`` (m); with a bore an ``expression`` is a pressure. A positive force pushes the journal along the
    guide's direction or, with ``reverse``, against it. ``force_back``, ``pressure_back`` or
    ``expression_back`` apply while the journal moves against the guide's direction: the area between both
    curves is the work of a turn.
    """

    kind = "guide"
    builder = "guide_force"
    sample: ClassVar[dict[str, Any]] = {"slider": "guide", "force": (3.0, -2.0), "travels": (-0.1, 0.1)}

    slider: str = described(
        Text("joint"),
        "the joint along whose guide it acts: a slider, a pin in a slot or a block with clearance",
    )
    force: float | tuple[float, ...] | None = described(
        Measure("N", series=True), "force along the guide: one, or one for each place of the table", None
    )
    pressure: float | tuple[float, ...] | None = described(
        Measure("Pa", series=True),
        "absolute pressure on the bore, or gauge if ambient is 0: one, or one for each place of the table",
        None,
    )
    force_back: tuple[float, ...] | None = described(
        Measure("N", series=True),
        "the force while the journal moves against the guide's direction, if different",
        None,
    )
    pressure_back: tuple[float, ...] | None = described(
        Measure("Pa", series=True),
        "the pressure while the journal moves against the guide's direction, if different",
        None,
    )
    bore: float | None = quantity("m", "diameter on which the pressure acts", None, above=0.0)
    ambient: float = quantity(
        "Pa", "absolute pressure on the other side, which is subtracted; 0 bar for gauge pressures", 0.0
    )
    reverse: bool = described(
        Switch(), "true: a positive force pushes the journal against the guide's direction", False
    )

    on_guide = True

    def conflicts(self) -> Iterator[Fault]:
        """Yield a fault for a load without size, with both force and pressure, or a pressure without bore."""
        if self.force is not None and self.pressure is not None:
            yield Fault(("pressure",), "a force and a pressure exclude each other", remedy="keep one of them")
        elif self.force is None and self.pressure is None and not self.expression:
            yield Fault(
                ("",), "the size of the load is missing", remedy="give it a force, or a pressure and a bore"
            )
        elif self.pressure is not None and self.bore is None:
            yield Fault(
                ("bore",),
                "a pressure acts on a bore, which is missing",
                remedy='add it, as in bore = "50 mm"',
            )
        for key in ("bore", "ambient", "pressure_back"):  # what an expression is, the bore says
            if self.force is not None and self.pressure is None and getattr(self, key):
                yield Fault((key,), f"{key} goes with a pressure, not with a force", remedy="remove it")
        if self.pressure is not None and self.force_back is not None:
            yield Fault(
                ("force_back",),
                "force_back goes with a force, not with a pressure",
                remedy="call it pressure_back",
            )

    @property
    def keys(self) -> tuple[str, str]:
        """Field names of its values and of the values of the return stroke."""
        return ("force", "force_back") if self.pressure is None else ("pressure", "pressure_back")

    @property
    def pressed(self) -> bool:
        """Whether its values are pressures."""
        return self.pressure is not None or bool(self.expression and self.bore)

    @property
    def ambient_pressure(self) -> float:
        """Ambient pressure (Pa), which is subtracted from an expression; 0 for a force."""
        return self.ambient if self.pressed else 0.0

    @property
    def unit(self) -> float:
        """Force (N) along the guide's direction per N of force or Pa of pressure."""
        area = 0.25 * math.pi * ((self.bore or 0.0) * (self.bore or 0.0)) if self.pressed else 1.0
        return -area if self.reverse else area

    @property
    def values(self) -> Values:
        """Forces (N), or pressures above ambient (Pa)."""
        return self.force if self.pressure is None else self._gauge(self.pressure)

    @property
    def values_back(self) -> Values:
        """Those of the return stroke."""
        return self.force_back if self.pressure is None else self._gauge(self.pressure_back)

    def _gauge(self, pressure: Values) -> Values:
        if isinstance(pressure, Sequence):
            return tuple(value - self.ambient for value in pressure)
        return None if pressure is None else pressure - self.ambient

    @property
    def words(self) -> str:
        """Description for readers."""
        out, back = self.way(self.values, self.expression), self.way(self.values_back, self.expression_back)
        largest = abs(self.unit) * max(
            (way.largest for way in (out, back) if way is not None), default=abs(self.constant)
        )
        quantity_name = f"pressure on a bore of {self.bore:.6g} m," if self.pressed else "force"
        return f"{quantity_name} {'up to ' if self.axis else ''}{largest:.6g} N along the guide{self.by}"

    @property
    def measured(self) -> tuple[str, str]:
        """Unit and meaning of its function."""
        return (
            ("Pa", "pressure of the load above ambient")
            if self.pressed
            else ("N", "force of the load along its guide")
        )

    def pushes(self, joints: Mapping[str, Joint]) -> tuple[Push, ...]:
        """Return the force on the journal and its opposite on the bearing. Raises ValueError if the joint has
        no guide.
        """
        joint = joints[self.slider]
        guide = place_row(joint.rows())
        if not isinstance(guide, Guided):
            raise ValueError(f"load {self.name!r}: joint {self.slider!r} has no guide; name a slider")
        x, y = (self.unit * part for part in guide.unit())
        bearing, journal = joint.sides
        moving = bearing[0] != "ground"
        aligned = bearing[0] if moving else ""
        return Push(*journal, (x, y, 0.0), moving, aligned), Push(*bearing, (-x, -y, 0.0), moving)

"""The builders of loads and drivers, one for each kind; see :mod:`~vfife.model.builders`."""

from __future__ import annotations

from collections.abc import Sequence

from .adders import adds
from .drivers import AngleTable, ConstantSpeed, Harmonic, Ramp, StepTo, Torque
from .given import Place, Quantity
from .loads import GuideForce, PointForce
from .tabulated import Interpolation


class LoadBuilders:
    """What adds loads and drivers to a mechanism."""

    @adds("load", PointForce)
    def force(
        self, name: str, at: str, *, force: Place = (0.0, 0.0), moment: Quantity = 0.0, follow: bool = False,
        factors: Sequence[Quantity] | None = None, factors_back: Sequence[Quantity] | None = None, times: Sequence[Quantity] | None = None,
        angles: Sequence[Quantity] | None = None, travels: Sequence[Quantity] | None = None, speeds: Sequence[Quantity] | None = None,
        crank: str = "", slider: str = "", zero_angle: Quantity = 0.0, zero_travel: Quantity = 0.0, repeat: bool | None = None,
        interpolation: Interpolation = "monotone",
        expression: str = "", expression_back: str = "",
    ) -> PointForce:  # fmt: skip
        """Adds a force and a moment at a pin, ``body.pin``; see :class:`~vfife.model.loads.PointForce`."""
        raise NotImplementedError

    @adds("load", PointForce)
    def moment(
        self, name: str, at: str, *, moment: Quantity, factors: Sequence[Quantity] | None = None,
        factors_back: Sequence[Quantity] | None = None, times: Sequence[Quantity] | None = None, angles: Sequence[Quantity] | None = None,
        travels: Sequence[Quantity] | None = None, speeds: Sequence[Quantity] | None = None, crank: str = "", slider: str = "",
        zero_angle: Quantity = 0.0, zero_travel: Quantity = 0.0, repeat: bool | None = None, interpolation: Interpolation = "monotone",
        expression: str = "", expression_back: str = "",
    ) -> PointForce:  # fmt: skip
        """Adds a moment on the body of a pin, ``body.pin``; see :class:`~vfife.model.loads.PointForce`."""
        raise NotImplementedError

    @adds("load", GuideForce)
    def guide_force(
        self, name: str, slider: str, *, force: Quantity | Sequence[Quantity] | None = None,
        pressure: Quantity | Sequence[Quantity] | None = None, bore: Quantity | None = None, ambient: Quantity = 0.0,
        force_back: Quantity | Sequence[Quantity] | None = None, pressure_back: Quantity | Sequence[Quantity] | None = None,
        reverse: bool = False, times: Sequence[Quantity] | None = None, angles: Sequence[Quantity] | None = None,
        travels: Sequence[Quantity] | None = None, speeds: Sequence[Quantity] | None = None, crank: str = "", zero_angle: Quantity = 0.0,
        zero_travel: Quantity = 0.0, repeat: bool | None = None, interpolation: Interpolation = "monotone",
        expression: str = "", expression_back: str = "",
    ) -> GuideForce:  # fmt: skip
        """Adds a force along the guide of a joint, as gas has it in a cylinder; see :class:`~vfife.model.loads.GuideForce`."""
        raise NotImplementedError

    @adds("driver", Torque)
    def torque(
        self, body: str, *, value: Quantity | Sequence[Quantity], times: Sequence[Quantity] | None = None,
        speeds: Sequence[Quantity] | None = None, angles: Sequence[Quantity] | None = None, against: str = "ground",
        interpolation: Interpolation = "monotone",
    ) -> Torque:  # fmt: skip
        """Adds a torque on a body, constant or over time, speed or angle; see :class:`~vfife.model.drivers.Torque`."""
        raise NotImplementedError

    @adds("driver", ConstantSpeed)
    def drive(self, body: str, *, speed: Quantity) -> ConstantSpeed:
        """Turns a body at constant speed (rad/s, or "1500 rpm") about its ideal joint to the ground."""
        raise NotImplementedError

    @adds("driver", Ramp)
    def ramp(
        self, body: str = "", *, speed: Quantity, duration: Quantity, slider: str = "", point: str = "", direction: Place = (1.0, 0.0),
        against: str = "ground",
    ) -> Ramp:  # fmt: skip
        """Brings a body, a slider or a pin smoothly from rest to a speed; see :class:`~vfife.model.drivers.Ramp`."""
        raise NotImplementedError

    @adds("driver", StepTo)
    def step_to(
        self, body: str = "", *, travel: Quantity, duration: Quantity, begin: Quantity = 0.0, slider: str = "", point: str = "",
        direction: Place = (1.0, 0.0), against: str = "ground",
    ) -> StepTo:  # fmt: skip
        """Moves a body, a slider or a pin from rest to rest; see :class:`~vfife.model.drivers.StepTo`."""
        raise NotImplementedError

    @adds("driver", Harmonic)
    def harmonic(
        self, body: str = "", *, amplitude: Quantity, frequency: Quantity, phase: Quantity = 0.0, slider: str = "", point: str = "",
        direction: Place = (1.0, 0.0), against: str = "ground",
    ) -> Harmonic:  # fmt: skip
        """Swings a body, a slider or a pin to and fro; see :class:`~vfife.model.drivers.Harmonic`."""
        raise NotImplementedError

    @adds("driver", AngleTable)
    def motion(
        self, body: str = "", *, times: Sequence[Quantity], values: Sequence[Quantity], slider: str = "", point: str = "",
        direction: Place = (1.0, 0.0), against: str = "ground",
    ) -> AngleTable:  # fmt: skip
        """Leads a body, a slider or a pin through angles or travels at given times; see :class:`~vfife.model.drivers.AngleTable`."""
        raise NotImplementedError

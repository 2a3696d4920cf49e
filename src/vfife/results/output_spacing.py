"""Measures of a study that are taken at the outputs and whose error depends on the spacing of these.

``rms(C.force)`` is computed from the force at the outputs. An impact lasts a few times 10 us and may lie
between two outputs, so that the reduction of a contact force errs by tens of per cent however fine the step
is. The error of the step, which a repetition with another step shows, says nothing about that. Positions and
velocities are integrals of the forces, and outputs that draw them resolve them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..store.studyfile import REPEATS
from .series import REDUCTION

SMOOTH = ("m", "rad", "m/s", "rad/s", "J")  # units of channels that an impact does not raise for a moment
EXTREME = "_max)"  # channels of the largest values of all steps, as in max(C.force_max)
# Measures that are largest values or means at the outputs, by the ends of their names.
AT_OUTPUTS = (
    ".shaking_force.max", ".shaking_moment.max", ".acceleration.max", ".tension.max", ".compression.max",
    ".torque.ripple", ".torque.rms", ".energy_fluctuation",
    ".pressure_velocity.max", ".pressure_velocity.mean",
)  # fmt: skip
FIRST_ORDER = 1  # of the step in a study of a mechanism with contact


def depends_on_outputs(measures: Mapping[str, str], meta: Mapping[str, Any]) -> list[str]:
    """Return the measures of a study of a mechanism with contact whose error depends on the outputs.

    measures: units by name, as in {"rms(C.force)": "N"}
    meta: that of the study file
    """
    if meta.get(REPEATS, {}).get("order") != FIRST_ORDER:
        return []
    return [
        name
        for name, unit in measures.items()
        if name.endswith(AT_OUTPUTS)
        or (REDUCTION.fullmatch(name) and unit not in SMOOTH and not name.endswith(EXTREME))
    ]

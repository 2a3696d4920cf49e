"""Drivers in the answer of a run: power and largest force of actuators, and the speed of torques."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from ..measures.actuators import actuators, quantity_of
from ..measures.values import NOT_ESTIMATED
from ..results.run_data import RunData
from .digits import Json, largest_of_turns, prefixed, sum_text, value_text

ROUNDING = 1e-6  # of the largest power at the outputs: a smaller mean is rounding


def actuator_summary(result: RunData, ideal: Any) -> Json:
    """Return for each actuator the ``measure`` of its largest force or torque with that of the ``ideal``
    mechanism, and its largest power at the outputs (``power``, W), as an entry of a summary; nothing without
    actuators.
    """
    powers = np.abs(result.record.block("actuator_power")).max(axis=0).tolist()
    entries = {}
    for (name, linear), power in zip(actuators(result.record).items(), powers, strict=True):
        quantity, unit = quantity_of(linear)
        measure = f"{name}.{quantity}.max"
        entries[name] = {"measure": measure, "unit": unit, "ideal": ideal.get(measure), "power": power}
    return {"actuators": entries} if entries else {}


def actuator_facts(summary: Json) -> Iterator[tuple[str, str]]:
    """Yield name and text of each actuator: mean power, and largest force or torque."""
    friction = [measure for measure in summary["measures"] if measure.endswith(".friction_power.mean")]
    lost = sum(summary["measures"][measure] for measure in friction)
    losses = f" ({sum_text(summary, friction, 'W')} friction)" if lost else ""
    for name, actuator in summary.get("actuators", {}).items():
        measure, power = actuator["measure"], f"{name}.actuator_power.mean"
        texts = []
        if abs(summary["measures"].get(power, 0.0)) > ROUNDING * actuator["power"]:
            texts.append(f"mean power {value_text(summary, power, 'W')}{losses}")
        if measure in summary["measures"]:
            word = "force" if actuator["unit"] == "N" else "torque"
            ideal = actuator["ideal"]
            compared = "" if ideal is None else f" (ideal {prefixed(ideal, actuator['unit'])})"
            largest = largest_of_turns(summary, measure, actuator["unit"])
            texts.append(f"largest {word} {largest}{compared}")
        yield name, ", ".join(texts)


def speed_text(speed: Json) -> str:
    """Return the speed that a torque has given a body, and between which speeds it varied."""
    low, high, end = (f"{speed[key]:.4g} rad/s" for key in ("low", "high", "end"))
    rpm = f"{30.0 * speed['end'] / math.pi:,.4g} rpm"
    return f"{end} ({rpm}) at the end, least {low}, largest {high} ({NOT_ESTIMATED})"

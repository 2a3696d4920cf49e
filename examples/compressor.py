"""
What clearance costs a compressor
=================================

A small air compressor (8.4 bar, 1450 rpm) has clearance between piston and cylinder and in both pins of its
rod. This example compares three machines: ideal joints, new parts, and parts worn to four times their
clearance. It answers: what does clearance cost in force, in energy and in noise?
"""

# %%
# Three runs of twenty turns. New parts have the fits 28 mm H7/f7 and 16 mm H7/g6.

import math
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import vfife
from vfife import gallery

TURNS = 20
JOINTS = ("big-end", "small-end", "cylinder")
results = {}
for name, wear in (("ideal", 0), ("new", 1), ("worn", 4)):
    machine = gallery.compressor(wear=wear, turns=TURNS)
    machine.name = f"{name} {machine.name}"  # titles of figures say which machine they show
    results[name] = vfife.simulate(machine)

# %%
# The comparison. Every run with contact is repeated three times with other step sizes ("companion runs"). The
# table shows a range wherever these runs differ by more than the last digit.


def shown(result: vfife.Result, names: list[str], unit: float, digits: int) -> str:
    """Return the sum of some measures in a unit, from its lowest to its highest plausible value."""
    found = [result.measures[name] for name in names if name in result.measures]
    low, high = (sum(one.low for one in found) / unit, sum(one.high for one in found) / unit)
    if not found:
        return "-"
    if f"{low:,.{digits}f}" == f"{high:,.{digits}f}":
        return f"{low:,.{digits}f}"
    return f"up to {up(high, digits)}" if low < 0.1**digits else f"{down(low, digits)} to {up(high, digits)}"


def down(value: float, digits: int) -> str:
    """Return the lower end of a range, rounded downwards."""
    return f"{math.floor(value * 10**digits) / 10**digits:,.{digits}f}"


def up(value: float, digits: int) -> str:
    """Return the upper end of a range, rounded upwards."""
    return f"{math.ceil(value * 10**digits) / 10**digits:,.{digits}f}"


LINES = {
    "peak force on the big end, kN": (["big-end.force.max"], 1e3, 1),
    "peak force on the small end, kN": (["small-end.force.max"], 1e3, 1),
    "peak force on the cylinder wall, N": (["cylinder.force.max"], 1.0, 0),
    "peak torque of the motor, N m": (["crank.torque.max"], 1.0, 0),
    "mean power of the motor, W": (["crank.power.mean"], 1.0, 0),
    "friction in pins and cylinder, W": ([f"{joint}.friction_power.mean" for joint in JOINTS], 1.0, 0),
    "energy lost in knocks, mW": ([f"{joint}.impact_power.mean" for joint in JOINTS], 1e-3, 0),
    "hardest knock of the small end, mm/s": (["small-end.approach_speed.max"], 1e-3, 0),
}
ideal, new, worn = (results[name].measures for name in ("ideal", "new", "worn"))
print(f"{new.part.partition(',')[0]:40}{'ideal':>12}{'new':>14}{'worn':>16}")
for line, (names, unit, digits) in LINES.items():
    cells = [shown(result, names, unit, digits) for result in results.values()]
    print(f"{line:40}{cells[0]:>12}{cells[1]:>14}{cells[2]:>16}")

# %%
# The conclusion, from the same numbers. The hardest knock is the hardest of the whole run.

friction = sum(new[f"{joint}.friction_power.mean"] for joint in JOINTS)
knocks = [sum(machine[f"{joint}.impact_power.mean"] for joint in JOINTS) for machine in (new, worn)]
force = worn["small-end.force.max"]
share = [100 * (value / ideal["small-end.force.max"] - 1) for value in (force.low, force.high)]
excess = f"{down(share[0], 0)} to {up(share[1], 0)}" if share[0] > 0 else f"up to {up(share[1], 0)}"
print(
    f"\nFriction takes {friction:.0f} W of {new['crank.power.mean']:.0f} W, new or worn. Wear is heard "
    f"rather than paid for:\n"
    f"knocks lose {knocks[1] / knocks[0]:.1f} times the energy, and the small end carries "
    f"{excess} % more than an ideal joint."
)

# %%
# Force on the small end over the last turn. The gas presses the pin to one side while the piston rises, and
# clearance has little effect there. After top dead centre the force is small and changes its direction: the
# worn pin crosses its clearance and knocks.


def last_turn(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the crank angle (degrees) and the force on the small end (kN) over the last turn."""
    result = results[name]
    turn = slice(-round(len(result.time) / TURNS), None)
    angle = np.degrees(result.series["crank.angle"].values[turn]) % 360
    order = np.argsort(angle)
    return angle[order], 1e-3 * result.series["small-end.force_max"].values[turn][order]


comparison = Figure(figsize=(7.0, 3.0), layout="constrained")
axes = comparison.subplots()
axes.plot(*last_turn("worn"), lw=0.9, label="worn to four times its clearance")
axes.plot(*last_turn("ideal"), lw=1.8, label="ideal joint")
axes.set(xlim=(0, 360), ylim=(0, None), xticks=range(0, 361, 60))
axes.set(xlabel="crank angle (degrees; 0 = top dead centre)", ylabel="force on the small end (kN)")
axes.legend(frameon=False)

# %%
# The same for all joints, and the paths of the pins in their bearings.

figures = results["worn"].plot("forces", "orbits") | results["new"].plot("mechanism")

# %%
# The ideal compressor takes the power of its gas alone, 778 W. The rest is friction, which ideal joints lack.

if len(sys.argv) == 2:
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for name, figure in {**figures, "comparison": comparison}.items():
        figure.savefig(folder / f"{name}.png", dpi=120, bbox_inches="tight")
    print(f"\nFigures: {', '.join(sorted(path.name for path in folder.glob('*.png')))} in {folder}")

assert abs(ideal["crank.power.mean"] - 778.0) < 2.0

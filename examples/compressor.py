"""
What play costs a compressor
============================

A small air compressor, 8.4 bar at 1450 rpm, with its gas in the cylinder and play in the main bearing and
both pins of its rod: as new, and worn to four times that. What does the play cost in force, in noise and in
energy?
"""

# %%
# Three runs: with ideal joints, as new (28 mm H7/f7 and 16 mm H7/g6), and worn.

import sys
from pathlib import Path

import vfife
from vfife import gallery

PLAY = ("big-end", "small-end", "cylinder")
results = {
    name: vfife.simulate(gallery.compressor(wear=wear))
    for name, wear in (("ideal", 0), ("new", 1), ("worn", 4))
}

# %%
# The answer. Where runs with other step sizes differ, the range is what is known.


def told(result: vfife.Result, names: list[str], unit: float, digits: int) -> str:
    """The sum of some measures over the last turn in a unit, from what it is at least to what it is at most."""
    found = [result.measures[name] for name in names if name in result.measures]
    low, high = (
        f"{value / unit:,.{digits}f}"
        for value in (sum(one.low for one in found), sum(one.high for one in found))
    )
    return (low if low == high else f"{low} to {high}") if found else "-"


LINES = {
    "largest force, big end, kN": (["big-end.force.max"], 1e3, 1),
    "largest force, small end, kN": (["small-end.force.max"], 1e3, 1),
    "hardest blow on the cylinder wall, N": (["cylinder.force.max"], 1.0, 0),
    "noise: hardest knock, small end, mm/s": (["small-end.approach_speed.max"], 1e-3, 0),
    "noise: energy of the knocks, mW": ([f"{joint}.impact_power.mean" for joint in PLAY], 1e-3, 0),
    "friction of pins and piston, W": ([f"{joint}.friction_power.mean" for joint in PLAY], 1.0, 0),
    "power of the motor, W": (["crank.power.mean"], 1.0, 0),
    "torque of the motor, largest, N m": (["crank.torque.max"], 1.0, 0),
}
print(f"{'over a turn, without and with play':38}" + "".join(f"{name:>17}" for name in results))
for line, (names, unit, digits) in LINES.items():
    print(f"{line:38}" + "".join(f"{told(result, names, unit, digits):>17}" for result in results.values()))

ideal, new, old = (results[name].measures for name in results)
lost, louder = (
    new["crank.power.mean"] - ideal["crank.power.mean"],
    old["small-end.approach_speed.max"] / new["small-end.approach_speed.max"],
)
harder = old["small-end.force.max"].high / ideal["small-end.force.max"]
print(
    f"\nWith play, pins rub: {lost:.0f} W of {new['crank.power.mean']:.0f} W. Worn to four times its play, the compressor needs no more power,"
)
print(
    f"but its small end knocks {louder:.1f} times as fast, with up to {harder:.2f} times the ideal force, and the piston slaps."
)

# %%
# The gas presses the pins to one side while the piston goes up, and play is hardly felt there. Once the dead
# space has blown out forces are small
# and change sign: the piston slaps to the other wall, and the small end flies and knocks.

worn = results["worn"].plot("forces", "orbits")
drawn = results["new"].plot("mechanism")["mechanism"]

# %%
# The mean power of the ideal compressor is that of its gas, 778 W; what play takes beyond that is friction,
# of which ideal pins have none.

if len(sys.argv) == 2:
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for name, figure in {**worn, "mechanism": drawn}.items():
        figure.savefig(folder / f"{name}.png", dpi=120, bbox_inches="tight")
    print(f"Figures: {', '.join(sorted(path.name for path in folder.glob('*.png')))} in {folder}")

assert abs(results["ideal"].measures["crank.power.mean"] - 778.0) < 2.0

"""Answer both problems with vfife, at its automatic step or one that is given, and score the answer.

    python answer_of_vfife.py [four_bar] [--step "0.1 us"]

It writes answer.csv and largest.csv into a folder answers/ beside the problem's references.
"""

from __future__ import annotations

import argparse
import csv
import time
from pathlib import Path

import score

import vfife

HERE = Path(__file__).parent
ROWS = 800
BODY = {"x": "x [m]", "y": "y [m]", "angle": "angle [rad]", "w": "angular_velocity [rad/s]"}
FOUR_BAR = {
    **{
        f"{body}_{key}": f"{body}.{column}"
        for body in ("coupler", "follower")
        for key, column in BODY.items()
    },
    **{f"force_{joint}": f"{joint}.force [N]" for joint in "BCD"},
    **{f"depth_{joint}": f"{joint}.penetration [m]" for joint in "BCD"},
    "follower_acceleration": "follower.angular_acceleration [rad/s^2]",
}
SLIDER_CRANK = {
    "rod_angle": "rod.angle [rad]",
    "block_x": "block.x [m]",
    "rod_w": "rod.angular_velocity [rad/s]",
    "force": "pin.force [N]",
    "depth": "pin.penetration [m]",
    "rod_acceleration": "rod.angular_acceleration [rad/s^2]",
}
LARGEST = {
    "four_bar": {
        **{f"force_{joint}": f"{joint}.force.max" for joint in "BCD"},
        "follower_acceleration": "follower.angular_acceleration.max",
    },
    "slider_crank": {"force": "pin.force.max", "rod_acceleration": "rod.angular_acceleration.max"},
}
COLUMNS = {"four_bar": FOUR_BAR, "slider_crank": SLIDER_CRANK}


def answer(problem: str, step: str, folder: Path) -> float:
    """Run the model of a problem and write its tables; returns the seconds that the run took."""
    model = vfife.load(HERE / problem / "model.toml")
    begin = time.perf_counter()
    result = vfife.simulate(model, turns=2, outputs=ROWS // 2, step=step, reference=False, companions=0)
    took = time.perf_counter() - begin
    frame = result.to_dataframe()
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "answer.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["t", *COLUMNS[problem]])
        for t, *values in zip(frame.index, *(frame[name] for name in COLUMNS[problem].values()), strict=True):
            writer.writerow([f"{t:.9g}", *(f"{x:.12g}" for x in values)])
    with (folder / "largest.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["quantity", "largest"])
        writer.writerows([name, f"{result.measures[key]:.10g}"] for name, key in LARGEST[problem].items())
    return took


def main() -> None:
    """Read the command line, answer and score."""
    parser = argparse.ArgumentParser(description="Answer the problems with vfife.")
    parser.add_argument("problems", nargs="*", default=list(COLUMNS))
    parser.add_argument("--step", default="auto")
    options = parser.parse_args()
    for problem in options.problems:
        folder = HERE / problem / "answers"
        took = answer(problem, options.step, folder)
        print(f"{problem}: {took:.2f} s")
        score.main([problem, str(folder / "answer.csv"), "--largest", str(folder / "largest.csv")])
        print()


if __name__ == "__main__":
    main()

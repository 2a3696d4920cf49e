"""Models that the tests of the command line run."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CASE_C = ROOT / "examples" / "four_bar_case_c.toml"

PENDULUM = """name = "pendulum"
gravity = [0, -9.81]
[run]
duration = 0.05
[ground]
O = [0, 0]
[body.rod]
length = "1 m"
mass = 2
[joint.J]
bearing = "ground.O"
journal = "rod.start"
"""

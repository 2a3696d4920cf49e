"""``vfife waterfall``: a file, a picture and a table; sentences for what it cannot do."""

import math
import re
from collections.abc import Callable
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
CRANK = EXAMPLES / "slider_crank.toml"
BRIEF = (
    "--over",
    "driver.crank.speed=500..1500rpm",
    "--count",
    "2",
    "--turns",
    "2",
    "--last",
    "1",
    "--window",
    "rectangular",
    "--outputs",
    "120",
    "--of",
    "pin.force",
)


def test_a_waterfall_is_kept_drawn_and_told(command: Callable) -> None:
    done = command(
        "waterfall", CRANK, *BRIEF, "-o", "a.waterfall", "--csv", "a.csv", "--hertz", "--figure", "a.svg"
    )
    assert done.exit_code == 0, done.stderr
    assert (
        "2 runs" in done.stdout
        and "Steps of " in done.stdout
        and "no contacts; without companions" in " ".join(done.stdout.split())
    )
    assert "rectangular window over 1 turns, 1 dropped; resolution 1 orders; 120 outputs a turn" in " ".join(
        done.stdout.split()
    )
    rad, rpm = re.search(r"from (\S+) to .* rad/s \((\S+) to", " ".join(done.stdout.split())).groups()  # type: ignore[union-attr]
    assert (
        float(rpm) == pytest.approx(float(rad) * 60.0 / math.tau, rel=1e-3) and "2 of 2 runs" in done.stderr
    )
    assert (
        Path("a.svg").read_text().startswith("<?xml")
        and len(Path("a.csv").read_text().splitlines()) == 1 + 2 * 51
    )
    again = command("waterfall", CRANK, *BRIEF, "-o", "a.waterfall", "-q")
    assert again.exit_code == 0 and not again.stdout and Path("a-waterfall.png").exists()


def test_a_sweep_without_a_unit_is_questioned(command: Callable) -> None:
    """A bare 500..3000 is radians per second; nothing is computed here, the path being wrong in the end."""
    bare, plain = (
        command(
            "waterfall",
            EXAMPLES / "slider_crank_loose_pin.toml",
            "--over",
            f"driver.crank.speed={span}",
            "--of",
            "nowhere.force",
        )
        for span in ("500..3000", "500..3000rpm")
    )
    assert "in rad/s, 4,774.65 rpm to 28,647.9 rpm; is 500..3000rpm meant?" in bare.stderr
    assert "meant?" not in plain.stderr


def test_faults_are_sentences(command: Callable) -> None:
    for words, said in (
        (("--over", "driver.crank.sped=500..1500rpm"), "speed"),
        (("--over", "driver.crank.speed"), "LOW..HIGH"),
        (("--highest", "100"), "half the 120 outputs"),
        (("--figure", "a.gif"), ".png"),
        (("--window", "none"), "hann"),
    ):
        done = command("waterfall", CRANK, *BRIEF, *words)
        assert done.exit_code == 2 and said in " ".join(done.stderr.split()), done.stderr
        assert "Traceback" not in done.stderr

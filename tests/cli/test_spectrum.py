"""``vfife spectrum``: the strongest waves, figures and tables, and sentences for what cannot be."""

import csv
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import vfife


@pytest.fixture(scope="module")
def shaken(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A crank of 10 turns a second, of whose pin nothing but its own weight and 3 N at the fifth order is
    felt.
    """
    m = vfife.Mechanism("shaken crank")
    m.point("O", 0.0, 0.0)
    m.link("crank", length=0.1, mass=1.0)
    m.revolute("O", "ground.O", "crank.start")
    m.drive("crank", speed=20.0 * math.pi)
    m.force("shaker", "crank.start", force=(3.0, 0.0), expression="cos(5 * angle)")
    path = tmp_path_factory.mktemp("shaken") / "run.sqlite"
    vfife.simulate(m, turns=4, outputs=180, companions=0, reference=False).save(path)
    return path


def test_the_strongest_waves_are_told(command: Callable, shaken: Path) -> None:
    done = command("spectrum", shaken, "--of", "O.force_x", "--figure", "s.png", "--csv", "s.csv")
    assert done.exit_code == 0, done.stderr
    lines = [line.split() for line in done.stdout.splitlines()]
    assert ["5", "50", "3", "N"] in lines or ["O.force_x", "5", "50", "3", "N"] in lines
    assert "Hann windows of 4 turns, overlapping by 50 %; resolution 0.375 orders or 3.75 Hz." in done.stdout
    rows = list(csv.reader(Path("s.csv").read_text().splitlines()))
    assert rows[0][:3] == ["frequency [Hz]", "order [1]", "O.force_x [N]"] and Path(
        "s.png"
    ).read_bytes().startswith(b"\x89PNG")
    high = max((row for row in rows[2:]), key=lambda row: float(row[2]) if float(row[1]) > 3.0 else 0.0)
    assert [float(one) for one in high[:3]] == pytest.approx([50.0, 5.0, 3.0], rel=1e-3)


def test_spectrograms_and_envelopes(command: Callable, shaken: Path) -> None:
    words = ("--as", "spectrogram", "--turns", "1", "--window", "rectangular", "--figure", "g.svg", "--hertz")
    done = command("spectrum", shaken, "--of", "O.force_x", *words)
    assert done.exit_code == 0, done.stderr
    assert (
        "order" not in done.stdout.split("Rect")[0].replace("waves", "")
        and "frequency (Hz)" in Path("g.svg").read_text()
    )
    done = command(
        "spectrum",
        shaken,
        "--of",
        "O.force_x",
        "--as",
        "envelope",
        "--band",
        "40..60Hz",
        "--csv",
        "e.csv",
        "--figure",
        "e.pdf",
    )
    assert done.exit_code == 0, done.stderr
    values = np.array(
        [[float(one) for one in row] for row in list(csv.reader(Path("e.csv").read_text().splitlines()))[1:]]
    )
    assert values[:, 2] == pytest.approx(3.0, rel=0.02)


@pytest.mark.parametrize(
    "words, said",
    [
        (("--of", "O.forc"), "no series"),
        (("O.force",), "(O.force); name a series with --of"),
        (("--as", "cepstrum"), "allowed: spectrum, spectrogram, envelope"),
        (("--of", "O.force", "--length", "1h"), "720"),
        (("--of", "O.force", "--length", "5ms", "--turns", "1"), "not both"),
        (("--of", "O.force", "--of", "O.force_x", "--csv", "a.csv"), "one table holds one series"),
        (("--band", "1..2kHz"), "only an envelope"),
        (("--as", "envelope", "--band", "1kHz"), "LOW..HIGH"),
        (
            ("--as", "envelope", "--length", "5ms", "--window", "hann"),
            "--window, --length: an envelope covers the whole run",
        ),
        (("--figure", "a.gif"), ".png or .svg or .pdf"),
        (("--of", "O.force", "--overlap", "1.5"), "overlap 1.5"),
    ],
)
def test_faults_are_sentences(command: Callable, shaken: Path, words: tuple[str, ...], said: str) -> None:
    done = command("spectrum", shaken, *words)
    assert done.exit_code == 2 and said in " ".join(done.stderr.split()), done.stderr
    assert "Traceback" not in done.stderr

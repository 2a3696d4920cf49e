"""What samples, designs and searches of a study tell on the command line; their cases are of closed form,
so the answers are known.
"""

from __future__ import annotations

import json
import math
import statistics
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from fake_card import FakeDriver, in_this_machine
from studies.studies import BASE, Closed
from vfife.studies import forecast
from vfife.studies.engine import cluster, study_engine
from vfife.studies.spec.distributions import of_fit

pytest.importorskip("SALib")
pytest.importorskip("optuna")

Command = Callable[..., Any]
HEAD = f"""
model = "{BASE.as_posix()}"
measures = ["C.force.max", "C.impacts"]
turns = 2
"""
PLAY = """
[vary.play]
path = "joint.C.clearance"
fit = "H8/f7"
diameter = "20 mm"
"""
SPEED = """
[vary.speed]
path = "driver.crank.speed"
from = 100
to = 200
"""


@pytest.fixture
def closed(monkeypatch: pytest.MonkeyPatch) -> Closed:
    """C.force.max = v² c, and v = 100 where the speed is not varied."""
    found = Closed()
    monkeypatch.setattr(study_engine, "run_cases", found)
    monkeypatch.setattr(forecast, "SAMPLE_CASES", 2)  # cases that are assembled to tell what all will cost
    monkeypatch.setattr(forecast, "WORTH", math.inf)  # and none of them are run for it
    return found


def told(command: Command, *words: str) -> Any:
    done = command(*words, "--json")
    assert done.exit_code == 0, done.stderr
    return json.loads(done.stdout)


def test_tolerance_tells_quantiles_and_the_share_that_fails(
    command: Command, closed: Closed, tmp_path: Path
) -> None:
    """10⁴ times the clearance of a fit: quantiles are those of the fit, 5 % of 400 machines are beyond its 95
    % quantile.
    """
    fit = of_fit("H8/f7", 0.02)
    limit = 1e4 * float(fit.quantile(0.95))
    (tmp_path / "s.toml").write_text(
        HEAD + 'method = "random"\ncount = 400\n' + PLAY + f'[limit]\nC.force.max = "{limit:.12f} N"\n'
    )
    assert command("study", "s.toml", "-q").exit_code == 0
    found = told(command, "study", "tolerance", "runs/s.study", "--quantiles", "10, 50")["measures"][
        "C.force.max"
    ]
    assert found["limit"] == {"high": pytest.approx(limit)}
    for share in (0.1, 0.5):
        at = found["quantiles"][f"{share:g}"]
        assert at["low"] <= 1e4 * float(fit.quantile(share)) <= at["high"]
    assert found["failing"]["low"] <= 0.05 <= found["failing"]["high"]
    assert found["mean"] == pytest.approx(1e4 * float(fit.quantile(0.5)), rel=0.02)
    wrong = command("study", "tolerance", "runs/s.study", "--limit", f"C.force.max={1e3 * limit}")
    assert wrong.exit_code == 2 and "a unit is probably missing" in " ".join(wrong.stderr.split())
    meant = command("study", "tolerance", "runs/s.study", "--limit", f"C.force.max={1e3 * limit} N")
    assert (
        meant.exit_code == 0
        and command("study", "tolerance", "runs/s.study", "--limit", f"C.force.max={limit}").exit_code == 0
    )
    said = command(
        "study", "tolerance", "runs/s.study", "--limit", "C.impacts=200", "--confidence", "90"
    ).stdout
    assert (
        "do not keep the limit, at most 200" in said
        and "50 % are below" in said
        and "90 % confidence" in said
    )


def test_a_tolerance_is_of_what_was_drawn_alone(command: Command, closed: Closed, tmp_path: Path) -> None:
    """C.force.max = 1e4 c: its mean is that of the clearances that were drawn, whatever else
    is in the file.
    """
    text = (
        HEAD + 'method = "random"\ncount = 32\n[vary.play]\npath = "joint.C.clearance"\nnominal = "0.2'
        ' mm"\ntolerance = "0.05 mm"\n'
    )
    (tmp_path / "s.toml").write_text(text)
    command("study", "s.toml", "-q")
    before = told(command, "study", "tolerance", "runs/s.study")
    drawn = [one["joint.C.clearance"] for one in closed.computed]
    assert before["machines"] == len(set(drawn)) == 32
    assert before["measures"]["C.force.max"]["mean"] == pytest.approx(1e4 * sum(drawn) / 32, rel=1e-12)
    assert command("study", "add", "runs/s.study", "--point", "play=5 mm", "-q").exit_code == 0
    done = command("study", "tolerance", "runs/s.study")
    assert "32 machines" in done.stdout and "1 case of the file left out" in done.stderr
    assert told(command, "study", "tolerance", "runs/s.study") == before, "a point was not drawn"
    (tmp_path / "s.toml").write_text(text.replace("0.05 mm", "0.01 mm"))
    closed.computed.clear()
    command("study", "s.toml", "-q")
    found = told(command, "study", "tolerance", "runs/s.study")
    narrow = [one["joint.C.clearance"] for one in closed.computed]
    assert found["machines"] == len(narrow) == 32
    assert found["measures"]["C.force.max"]["deviation"] == pytest.approx(
        1e4 * statistics.stdev(narrow), rel=1e-9
    )
    done = command("study", "add", "runs/s.study", "--count", "5")
    assert (done.exit_code, "32 samples are asked for already" in done.stderr) == (2, True), done.stderr


def test_indices_of_a_product(command: Command, closed: Closed, tmp_path: Path) -> None:
    """v² c, v even over 100 to 200, c normal: shares of the variance of a product of independent numbers, in
    closed form.
    """
    normal = '[vary.play]\npath = "joint.C.clearance"\nmean = "0.2 mm"\ndeviation = "0.02 mm"\n'
    (tmp_path / "s.toml").write_text(HEAD + 'method = "saltelli"\ncount = 128\n' + normal + SPEED)
    assert command("study", "s.toml", "-q").exit_code == 0
    assert len(closed.computed) == 128 * 4
    found = told(command, "study", "indices", "runs/s.study", "--measure", "C.force.max")["measures"][
        "C.force.max"
    ]
    mean, square = (200**3 - 100**3) / 300, (200**5 - 100**5) / 500
    a, b = 0.1**2, (square - mean**2) / mean**2  # squared coefficients of variation
    whole = a + b + a * b
    assert [one["parameter"] for one in found] == ["play", "speed"]
    assert [one["first"] for one in found] == pytest.approx([a / whole, b / whole], abs=0.04)
    assert [one["total"] for one in found] == pytest.approx(
        [(a + a * b) / whole, (b + a * b) / whole], abs=0.04
    )
    assert "with others" in command("study", "indices", "runs/s.study").stdout


def test_effects_of_morris(command: Command, closed: Closed, tmp_path: Path) -> None:
    """C.impacts is the speed: half of its range of 100 rad/s moves it by 50, the clearance by nothing."""
    (tmp_path / "s.toml").write_text(HEAD + 'method = "morris"\ncount = 10\n' + PLAY + SPEED)
    assert command("study", "s.toml", "-q").exit_code == 0
    found = told(command, "study", "indices", "runs/s.study", "--measure", "C.impacts")["measures"][
        "C.impacts"
    ]
    assert {one["parameter"]: (one["size"], one["deviation"]) for one in found} == {
        "play": (0.0, 0.0),
        "speed": (50.0, pytest.approx(0.0, abs=1)),
    }
    assert (
        "size of the effect" in command("study", "indices", "runs/s.study", "--measure", "C.impacts").stdout
    )


ALLOCATION = (
    '[limit]\n"C.force.max" = "{limit} N"\n[cost.play]\nIT6 = 9\nIT7 = 5\nIT8 = 3\nIT9 ='
    ' 2\n[allocation]\nmeasure = "C.force.max"\n'
)


def test_the_cheapest_fit_is_found_and_nothing_is_computed_twice(
    command: Command, closed: Closed, tmp_path: Path
) -> None:
    """The 99 % quantile of 10⁴ c is under 0.34 N with H8/f7 (0.309) and not with H8/f8 (0.347), H9/f8 (0.41)
    or H9/f9.
    """
    (tmp_path / "s.toml").write_text(HEAD + PLAY + ALLOCATION.format(limit=0.34) + "count = 473\n")
    assert (
        1e4 * float(of_fit("H8/f7", 0.02).quantile(0.99))
        < 0.34
        < 1e4 * float(of_fit("H8/f8", 0.02).quantile(0.99))
    )
    found = told(command, "study", "allocate", "s.toml", "-q")
    assert found["fits"] == {"play": "H8/f7"}
    assert found["cost"] == 8.0
    assert [one["fits"]["play"] for one in found["rejected"]] == ["H9/f9", "H9/f8", "H8/f8"]
    assert found["quantile"] <= 0.34
    computed = len(closed.computed)
    said = command("study", "allocate", "s.toml").stdout
    assert "H8/f7" in said and "10 to 37 µm" in said and "cost 8; 3 choices" in said
    assert len(closed.computed) == computed
    done = command("study", "s.toml")
    assert (done.exit_code, "takes values" in done.stderr) == (2, True)


def test_no_fit_that_keeps_the_limit_is_exit_code_3(command: Command, closed: Closed, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(HEAD + PLAY + ALLOCATION.format(limit=0.1))
    done = command("study", "allocate", "s.toml", "--json")
    assert (done.exit_code, json.loads(done.stdout)["fits"]) == (3, None)
    assert "none of 7 choices keeps the limit" in done.stderr


SEARCH = '[optimise]\nminimise = ["C.force.max"]\ncases = 48\n[limit]\nC.impacts = {low = 150}\n'


def test_a_search_goes_on_where_it_was_broken_off(
    command: Command, closed: Closed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The least of v² c is on the limit of v: 150² · 0.1 mm = 2.25 N, least clearance and least speed
    allowed.
    """
    play = '[vary.play]\npath = "joint.C.clearance"\nvalues = ["0.1 mm", "0.2 mm"]\n'
    (tmp_path / "s.toml").write_text(HEAD + play + SPEED + SEARCH)
    whole = closed.__call__

    def broken(*words: Any, **more: Any) -> Any:
        if len(closed.computed) >= 32:
            raise KeyboardInterrupt
        yield from whole(*words, **more)

    monkeypatch.setattr(study_engine, "run_cases", broken)
    done = command("optimise", "s.toml")
    assert done.exit_code == 130
    assert "32 cases are complete; the same command continues" in done.stderr
    monkeypatch.setattr(study_engine, "run_cases", closed)
    found = told(command, "optimise", "s.toml")
    assert found["cases"] == 48 >= len(closed.computed)
    assert len({tuple(one.items()) for one in closed.computed}) == len(closed.computed)
    (best,) = found["best"]
    assert best["parameters"]["play"] == 1e-4
    assert 150 - 0.5 <= best["parameters"]["speed"] < 160
    assert best["measures"]["C.force.max"] == pytest.approx(1e-4 * best["parameters"]["speed"] ** 2)
    said = command("optimise", "s.toml").stdout
    assert "48 cases" in said and "the least of C.force.max" in said
    assert command("study", "show", "runs/s.study").exit_code == 0


@pytest.mark.system("a search of many runs")
def test_derivatives_lead_a_search_on_and_it_says_how_far(command: Command, tmp_path: Path) -> None:
    """A slider-crank's pin: m w² r (1 + r/l) is least with the longest rod and the shortest crank, where the
    two bounds are.
    """
    lengths = (
        '[vary.rod]\npath = "body.rod.length"\nfrom = 0.1\nto = 0.2\n[vary.crank]\npath ='
        ' "body.crank.length"\nfrom = 0.03\nto = 0.05\n'
    )
    head = (
        f'model = "{BASE.parents[1] / "examples" / "slider_crank.toml"}"\nmeasures = ["pin.force.max"]\nturns'
        " = 1\n"
    )
    (tmp_path / "s.toml").write_text(head + lengths + '[optimise]\nminimise = ["pin.force.max"]\ncases = 4\n')
    done = command("optimise", "s.toml", "--json")
    assert (
        "forecast: up to 20 cases more by derivatives" in done.stderr and "half the step" not in done.stderr
    )
    found = json.loads(done.stdout)
    assert 0 < found["refined"] == found["cases"] - 4 and found["why"] == ""
    (least,) = found["best"]
    assert least["parameters"] == pytest.approx({"rod": 0.2, "crank": 0.03})
    assert least["measures"]["pin.force.max"] == pytest.approx(0.14 * 1e4 * 0.03 * 1.15, rel=1e-6)
    assert f"the last {found['refined']} by derivatives" in command("optimise", "s.toml").stdout
    (tmp_path / "s.toml").write_text((tmp_path / "s.toml").read_text() + "refine = 1\n")
    assert "derivatives give no further improvement: refine = 1 cases are used up" in " ".join(
        command("optimise", "s.toml").stderr.split()
    )


@pytest.mark.parametrize("words", [("optimise",), ("study", "allocate")])
def test_a_search_tells_that_there_is_no_card(
    command: Command, closed: Closed, tmp_path: Path, words: tuple[str, ...]
) -> None:
    (tmp_path / "s.toml").write_text(
        HEAD + (SPEED + SEARCH if words == ("optimise",) else PLAY + ALLOCATION.format(limit=1))
    )
    with in_this_machine(FakeDriver(None, cuInit=100)):
        done = command(*words, "s.toml", "--device", "cuda")
    assert (done.exit_code, "the driver sees no card" in done.stderr) == (2, True), done.stderr
    done = command(*words, "s.toml", "--device", "gpu")
    assert (done.exit_code, 'device gpu: there is no such device; there is "cuda"' in done.stderr) == (
        2,
        True,
    ), done.stderr
    done = command(*words, "s.toml", "--device", "cuda", "--cluster", "local")
    assert (done.exit_code, "cluster local and device cuda exclude each other" in done.stderr) == (2, True), (
        done.stderr
    )
    assert not closed.computed and not Path("runs").exists()


def test_a_front_of_two_measures(command: Command, closed: Closed, tmp_path: Path) -> None:
    play = '[vary.play]\npath = "joint.C.clearance"\nfrom = "0.1 mm"\nto = "0.2 mm"\n'
    (tmp_path / "s.toml").write_text(
        HEAD + SPEED + play + '[optimise]\nminimise = ["C.force.max", "C.impacts"]\ncases = 16\n'
    )
    front = told(command, "optimise", "s.toml")["best"]
    assert front
    assert [one["measures"]["C.force.max"] for one in front] == sorted(
        one["measures"]["C.force.max"] for one in front
    )


@pytest.mark.parametrize(
    ("words", "text", "said"),
    [
        (("optimise",), HEAD + SPEED, "this table is missing"),
        (("optimise",), HEAD + PLAY + SEARCH, "this has a distribution"),
        (("optimise",), HEAD + SPEED + SEARCH.replace("C.force.max", "C.force.maxi"), "it is not measured"),
        (
            ("optimise",),
            HEAD + SPEED + SEARCH.replace("C.impacts", "D.impacts"),
            "a limit of a measure that is not listed",
        ),
        (
            ("optimise",),
            HEAD + SPEED + SEARCH.replace("{low = 150}", "{low = 150, high = 100}"),
            "no number is within this limit",
        ),
        (("optimise",), HEAD + SPEED + SEARCH.replace("cases", "case"), 'Did you mean "cases"?'),
        (
            ("study", "allocate"),
            HEAD + PLAY + ALLOCATION.format(limit=1).replace("IT6", "IT66"),
            "an unknown grade",
        ),
        (
            ("study", "allocate"),
            HEAD + PLAY + ALLOCATION.format(limit=1).replace("cost.play", "cost.pla"),
            'Did you mean "play"?',
        ),
        (
            ("study", "allocate"),
            HEAD + PLAY + ALLOCATION.format(limit=1).replace("= 9", '= "nine"'),
            "a number for each grade",
        ),
        (
            ("study", "allocate"),
            HEAD + SPEED + ALLOCATION.format(limit=1).replace("play", "speed"),
            "costs of what has no fit",
        ),
        (
            ("study", "allocate"),
            HEAD + PLAY + ALLOCATION.format(limit=1) + "count = 100\n",
            "too few machines",
        ),
        (
            ("study", "allocate"),
            HEAD + PLAY + ALLOCATION.format(limit=1).replace("1 N", "1 mm"),
            "C.force.max",
        ),
    ],
)
def test_what_cannot_be_searched_is_a_sentence(
    command: Command, closed: Closed, tmp_path: Path, words: tuple[str, ...], text: str, said: str
) -> None:
    (tmp_path / "s.toml").write_text(text)
    done = command(*words, "s.toml")
    assert (done.exit_code, said in done.stderr) == (2, True), done.stderr
    assert not closed.computed


def test_what_has_no_sample_or_no_cluster_is_a_sentence(
    command: Command, closed: Closed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "ANSWER", 0.2)
    (tmp_path / "s.toml").write_text(HEAD + '[vary]\n"joint.C.clearance" = [1e-4, 2e-4]\n')
    command("study", "s.toml", "-q")
    for words, said in (
        (("tolerance",), "chosen, not drawn"),
        (("indices",), "need a design"),
        (("tolerance", "--quantiles", "200"), "not percentages"),
        (("tolerance", "--limit", "C.force.max"), "not MEASURE=VALUE"),
        (("tolerance", "--limit", "C.force.max=3 mm"), "a length"),
    ):
        done = command("study", words[0], "runs/s.study", *words[1:])
        assert (done.exit_code, said in done.stderr) == (2, True), (words, done.stderr)
    done = command("study", "s.toml", "--cluster", "nowhere:0", "--force")
    assert done.exit_code == 2
    assert "cluster" in done.stderr


def test_a_search_is_forecast_and_an_absurd_one_is_refused_unless_it_is_meant(
    command: Command, closed: Closed, tmp_path: Path
) -> None:
    """16 cases are asked for. 29 machines show 90 % with 95 %, 0.9^29 < 0.05: the first batch of 128 has room
    for 18 of each of the 7 choices, and so at most all of their machines are reckoned with.
    """
    long, play = (
        HEAD.replace("turns = 2", "turns = 1000000"),
        '[vary.play]\npath = "joint.C.clearance"\nvalues = ["0.1 mm", "0.2 mm"]\n',
    )
    (tmp_path / "o.toml").write_text(long + play + SPEED + SEARCH.replace("48", "16"))
    (tmp_path / "a.toml").write_text(long + PLAY + ALLOCATION.format(limit=0.5) + "share = 0.9\n")
    for words, cases in ((("optimise", "o.toml"), 16), (("study", "allocate", "a.toml"), 29 * 7)):
        done = command(*words)
        assert (done.exit_code, f"for {cases} cases of" in done.stderr) == (2, True), done.stderr
        assert "this search takes about" in done.stderr and "add --yes to confirm" in done.stderr
        assert not closed.computed and not (tmp_path / "runs" / f"{words[-1][0]}.study").exists()
        done = command(*words, "--yes")
        assert (done.exit_code, f"forecast: {cases} cases, about " in done.stderr) == (0, True), done.stderr
        assert "at once in each" in done.stderr and f"kB in runs/{words[-1][0]}.study" in done.stderr
        assert f"forecast: {cases} cases" not in command(*words, "--yes").stderr, (
            "what the file has is not computed again"
        )
        assert cases / 2 <= len(closed.computed) <= 2 * cases
        closed.computed.clear()
    (tmp_path / "o.toml").write_text(HEAD + play + SPEED + SEARCH.replace("48", "50000"))
    done = command("optimise", "o.toml", "-o", "many.study")
    assert (done.exit_code, "for 50,000 cases of" in done.stderr) == (2, True), (
        "choosing them takes hours by itself"
    )

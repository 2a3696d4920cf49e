"""``vfife impacts``."""

import json

from typer.testing import CliRunner

import vfife
from support import journal_in_bearing
from vfife.cli.app import app
from vfife.laws import Frictionless, LankaraniNikravesh


def test_the_impacts_of_a_run(tmp_path) -> None:
    result = vfife.simulate(
        journal_in_bearing(0.5, friction=Frictionless()),
        duration=5e-3,
        step="1 us",
        outputs=500,
        companions=0,
    )
    result.save(tmp_path / "run.sqlite")
    said = CliRunner().invoke(app, ["impacts", str(tmp_path)])
    assert (
        said.exit_code == 0
        and f"{result.impacts.count} contacts began" in said.stdout
        and "speed, mm/s" in said.stdout
    )
    assert "crank" not in said.stdout and "--count" not in said.stdout
    assert result.impacts.count > 1
    assert (
        "The hardest 1, by speed (--count for more)"
        in CliRunner().invoke(app, ["impacts", str(tmp_path), "--count", "1"]).stdout
    )
    told = json.loads(CliRunner().invoke(app, ["impacts", str(tmp_path), "--json"]).stdout)
    assert (
        told["count"] == result.impacts.count == len(told["impacts"])
        and abs(told["impacts"][0]["speed"] - 0.5) < 1e-3
    )


def test_an_onset_is_shown_by_the_interval_in_which_it_lies(tmp_path) -> None:
    """The end of an output interval is never shown as the time of an onset, nor its crank angle."""
    model = vfife.gallery.slider_crank_loose_pin()
    result = vfife.simulate(model, turns=0.5, outputs=100, step="10 us", companions=0)
    result.save(tmp_path / "run.sqlite")
    said = " ".join(CliRunner().invoke(app, ["impacts", str(tmp_path), "--count", "1"]).stdout.split())
    (hardest,) = result.impacts.hardest(1)
    assert hardest.since < hardest.time and hardest.crank_since is not None
    assert f"{1e3 * hardest.since:.4f} to {1e3 * hardest.time:.4f}" in said
    assert f"{hardest.crank_since:.1f} to {hardest.crank:.1f}" in said
    assert "began between the two outputs whose times are shown" in said


def test_impacts_say_how_their_law_rebounds(tmp_path) -> None:
    """A run without --long does not: the rebound is a caution only where impacts are the answer."""
    model = journal_in_bearing(0.5, friction=Frictionless(), contact=LankaraniNikravesh(restitution=0.5))
    result = vfife.simulate(model, duration=1e-3, step="1 us", outputs=100, companions=0)
    result.save(tmp_path / "run.sqlite")
    fact = "with restitution 0.5 a free impact rebounds with 0.7252"
    assert fact in " ".join(CliRunner().invoke(app, ["impacts", str(tmp_path)]).stdout.split())
    assert (
        fact in json.loads(CliRunner().invoke(app, ["impacts", str(tmp_path), "--json"]).stdout)["notes"][0]
    )
    assert "rebounds" not in CliRunner().invoke(app, ["info", str(tmp_path)]).stdout
    long = " ".join(CliRunner().invoke(app, ["info", str(tmp_path), "--long"]).stdout.split())
    assert fact in long and "Warning: Joint" not in long


def test_no_run_is_told_in_words(tmp_path) -> None:
    said = CliRunner().invoke(app, ["impacts", str(tmp_path)])
    assert said.exit_code == 2 and "Traceback" not in said.output


def test_a_joint_in_which_no_contact_begins_is_passed_over(tmp_path) -> None:
    """Of two joints one may stay in contact, or in flight, for the whole run."""
    result = vfife.simulate(
        journal_in_bearing(0.0, friction=Frictionless()), duration=1e-4, step="1 us", outputs=10, companions=0
    )
    result.save(tmp_path / "run.sqlite")
    assert result.impacts.count == 0 and result.impacts.entries == ()
    said = CliRunner().invoke(app, ["impacts", str(tmp_path)])
    assert said.exit_code == 0 and said.stdout == "No contact began in this run.\n"


def test_the_fastest_impact_is_the_first_and_all_losses_add_up_to_the_ledger(tmp_path) -> None:
    result = vfife.simulate(
        journal_in_bearing(0.5, friction=Frictionless()),
        duration=5e-3,
        step="1 us",
        outputs=500,
        companions=0,
    )
    speeds = [one.speed for one in result.impacts.fastest(10)]
    assert speeds == sorted(speeds, reverse=True) and len(speeds) > 1
    result.save(tmp_path / "run.sqlite")
    said = " ".join(CliRunner().invoke(app, ["impacts", str(tmp_path)]).stdout.split())
    assert f"{1e3 * speeds[0]:.4g}" in said and said.index(f"{1e3 * speeds[0]:.4g}") < said.index(
        f" {1e3 * speeds[1]:.4g} "
    )


def test_contacts_of_the_start_are_stated_beside_those_that_began() -> None:
    from vfife.measures.contacts import Impact, Impacts
    from vfife.report.run_file import impacts

    one = Impact("pin", 0.0, 1e-3, None, 1, 0.2, 0.3, 1e-6)
    page = impacts(Impacts((one,), 0.125), 10)
    assert "They lost 0.3 J in all, contacts of the start 0.125 J more." in str(page.parts[0])

"""A study of short runs takes what its members take beside their steps: forecast by steps alone it was told a seventeenth of its time."""

from cli.models import ROOT
from vfife import load
from vfife.cli.forecast import expected


def test_members_take_time_beside_their_steps(tmp_path):
    base = load(ROOT / "examples" / "slider_crank.toml")
    seconds = [expected([{}], left, 0, base, 1, tmp_path / "s.study")["seconds"] for left in (0, 100, 10_000)]
    assert seconds[0] == 0.0 and 1.0 < seconds[1] < 20.0, "ten to a hundred members in a second are what is measured, whatever the steps"
    assert abs(seconds[2] - 100.0 * seconds[1]) < 1e-9 * seconds[2]

"""Lives are shown with two digits, in hours, and with the scatter of coefficients."""

import math

import pytest

from vfife.report.amounts import life_range_words, life_words

RPM = 0.02  # s, a turn at 3000 rpm


@pytest.mark.parametrize(
    ("turns", "turn", "scatter", "expected"),
    [
        (14_394_181.0, RPM, None, "about 14 million turns (80 h at 3,000 rpm)"),
        (
            14_394_181.0,
            RPM,
            math.sqrt(35.0),
            "about 14 million turns (80 h at 3,000 rpm); 2.4 to 86 million with the scatter of the wear"
            " coefficient",
        ),
        (2.5e9, None, None, "about 2.5 thousand million turns"),
        (1_234.0, 60.0, None, "about 1,200 turns (21 h at 1 rpm)"),
        (234.0, RPM, None, "about 230 turns (0.0013 h at 3,000 rpm)"),
        (
            45_000.0,
            None,
            10.0,
            "about 45,000 turns; 4,500 to 450,000 with the scatter of the wear coefficient",
        ),
    ],
)
def test_a_life_in_words(turns, turn, scatter, expected):
    assert life_words(turns, turn, scatter) == expected


@pytest.mark.parametrize(
    ("ends", "turn", "scatter", "expected"),
    [
        (
            (114_150.0, 3_821_422.0),
            60.0 / 2900.0,
            None,
            "0.11 to 3.9 million turns (0.65 to 22 h at 2,900 rpm)",
        ),
        ((2_000.0, 45_000.0), None, None, "2,000 to 45,000 turns"),
        (
            (2_000.0, 45_000.0),
            None,
            10.0,
            "2,000 to 45,000 turns; 200 to 450,000 with the scatter of the wear coefficient",
        ),
        ((2_000.0, math.inf), RPM, None, "more than 2,000 turns"),
    ],
)
def test_a_range_of_a_life_in_words(ends, turn, scatter, expected):
    """Rounded outwards."""
    assert life_range_words(*ends, turn, scatter) == expected

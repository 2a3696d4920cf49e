"""Mistakes in model files, as people make them: each is told in words that a mechanic understands, none
passes in silence, none is a traceback.
"""

import pytest

from cli.mistakes import CAUTION, FOUR_BAR, MISTAKES, SLIDER_CRANK


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_told(name, command, tmp_path):
    text, words, fault = MISTAKES[name]
    path = tmp_path / "mine.toml"
    path.write_text(text)
    done = command("check", path)
    told = done.stderr if fault else done.stdout
    assert done.exit_code == (2 if fault else 0), told
    assert "Traceback" not in done.output and not (fault and done.stdout)
    found = " ".join(told.split())
    assert all(word in found for word in words), found
    assert len(told) < (1500 if fault else 10_000)


def test_there_are_twenty_six_and_cautions_are_few():
    assert len(MISTAKES) == 26
    assert sum(fault == CAUTION for _, _, fault in MISTAKES.values()) == 5


@pytest.mark.parametrize("text", [FOUR_BAR, SLIDER_CRANK], ids=["four-bar", "slider-crank"])
def test_without_a_mistake_nothing_is_told(text, command, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    found = " ".join(command("check", path).stdout.split())
    for word in (
        "is not connected",
        "chain is open",
        "mirror image",
        "singular",
        "jams",
        "Numbers without a unit",
    ):
        assert word not in found

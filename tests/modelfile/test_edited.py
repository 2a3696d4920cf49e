"""One value of a model file changed where it stands: what tomllib reads is what was asked for, and no other
sign of the text has moved.
"""

import tomllib
from pathlib import Path

import pytest

from vfife.errors import ModelError
from vfife.modelfile.edits import edited

TEMPLATES = sorted(
    (Path(__file__).resolve().parents[2] / "src" / "vfife" / "modelfile" / "templates").glob("*.toml")
)
TEXT = """\
# a comment
name = "four # bar"  # another

[body.crank]
length = "100 mm" # of the crank
pins = { start = [0, 0], end = [1, 2] }
moments = [
  [0, 1],  # a row
  [2, 3]
]

[joint."C 1"]
contact.law = "hertz"
clearance = 0.1

[joint.D.contact]
law = "lankarani-nikravesh"
restitution = 0.9

[[other.list]]
x = 1
"""


def changed(text: str, path: tuple, written: str | None) -> tuple[list[str], list[str]]:
    """Lines that went away and lines that came."""
    one, other = text.splitlines(), edited(text, path, written).splitlines()
    return [line for line in one if line not in other], [line for line in other if line not in one]


@pytest.mark.parametrize(
    ("path", "written", "gone", "come"),
    [
        (("name",), '"a = b"', ['name = "four # bar"  # another'], ['name = "a = b"  # another']),
        (
            ("body", "crank", "length"),
            "0.2 m",
            ['length = "100 mm" # of the crank'],
            ['length = "0.2 m" # of the crank'],
        ),
        (
            ("body", "crank", "pins", "end"),
            "[1, 3]",
            ["pins = { start = [0, 0], end = [1, 2] }"],
            ["pins = { start = [0, 0], end = [1, 3] }"],
        ),
        (("body", "crank", "mass"), "2", [], ["mass = 2"]),
        (("joint", "C 1", "clearance"), None, ["clearance = 0.1"], []),
        (
            ("joint", "C 1", "contact", "law"),
            "lankarani-nikravesh",
            ['contact.law = "hertz"'],
            ['contact.law = "lankarani-nikravesh"'],
        ),
        (("joint", "C 1", "contact", "restitution"), "0.5", [], ["contact.restitution = 0.5"]),
        (("joint", "D", "contact", "restitution"), "0.5", ["restitution = 0.9"], ["restitution = 0.5"]),
        (("run", "turns"), "3", [], ["[run]", "turns = 3"]),
        (("note",), '"new"', [], ['note = "new"']),
        (("other", "list", 0, "x"), "2", ["x = 1"], ["x = 2"]),
    ],
)
def test_one_line_changes(path, written, gone, come):
    assert changed(TEXT, path, written) == (gone, come)
    here = tomllib.loads(edited(TEXT, path, written))
    for part in path[:-1]:
        here = here[part]
    assert (path[-1] in here) == (written is not None)


def test_a_list_over_lines_keeps_its_lines_and_comments():
    assert changed(TEXT, ("body", "crank", "moments", 1), "[2, 4]") == (["  [2, 3]"], ["  [2, 4]"])
    assert "[[0, 1], [2, 4], [5, 6]]" in edited(
        TEXT, ("body", "crank", "moments"), "[[0, 1], [2, 4], [5, 6]]"
    )


def test_a_key_stands_before_the_comment_of_the_next_table():
    text = edited('[run]\nturns = 2\n\n# how it starts\n[start]\nmode = "rough"\n', ("run", "outputs"), "360")
    assert text == '[run]\nturns = 2\noutputs = 360\n\n# how it starts\n[start]\nmode = "rough"\n'


def test_a_new_law_takes_away_what_it_has_no_use_for():
    text = edited(TEXT, ("joint", "D", "contact", "law"), "kelvin-voigt")
    assert tomllib.loads(text)["joint"]["D"]["contact"] == {"law": "kelvin-voigt"}


@pytest.mark.parametrize(
    ("path", "written"), [(("name", "x"), "1"), (("gone",), None), (("body", "crank", "pins", 5), "1")]
)
def test_what_cannot_be_changed_alone_is_told(path, written):
    with pytest.raises(ModelError, match="in the text of the file") as error:
        edited(TEXT, path, written)
    assert len(error.value.faults) == 1


@pytest.mark.parametrize(
    "path",
    [path for path in TEMPLATES if path.stem in ("cantilever", "compressor", "frame")],
    ids=lambda path: path.stem,
)
def test_values_of_a_template_can_be_changed(path):
    """Numbers and texts by themselves: one line is another, and what is read differs there alone."""
    text = path.read_text("utf-8")

    def walk(values, at=()):
        for name, one in values.items():
            yield from walk(one, (*at, name)) if isinstance(one, dict) else [(*at, name)]

    for at in list(walk(tomllib.loads(text)))[::4]:
        if at[-1] in ("law", "kind", "model"):
            continue
        found = edited(text, at, "17")
        assert (
            sum(one != other for one, other in zip(text.splitlines(), found.splitlines(), strict=False)) >= 1
        )
        here = tomllib.loads(found)
        for part in at[:-1]:
            here = here[part]
        assert here[at[-1]] == 17
        assert edited(found, at, None).count("\n") <= text.count("\n")

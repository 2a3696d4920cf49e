"""Names are text everywhere: on the console, in figures, in files, whatever signs they are made of."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

import vfife
from cli.test_hostile import CRANK
from vfife.cli.commands import law_drawing

NAMES = {
    "joint.P": "[/]",
    "joint.W": r"$\frac{1$",
    "joint.O": "[bold]x",
    "body.rod": "<b>&%s{0}",
    "body.block": "$_$^",
}


def renamed() -> str:
    text = CRANK.replace('name = "slider-crank"', r"name = '[/] $\frac{1$ <b> 100 %'")
    for table, name in NAMES.items():
        kind, _, old = table.partition(".")
        text = text.replace(f"[{table}]", f"[{kind}.'{name}']")
        if kind == "body":
            text = text.replace(f'"{old}.', f'"{name}.')
    return text


@pytest.mark.system("every command with a hostile name")
@pytest.mark.parametrize("clear", [False, True])
def test_names_are_text(command: Callable, clear: bool) -> None:
    text = renamed()
    if clear:
        text = text.replace(
            "[joint.'[/]']\n", "[joint.'[/]']\nkind = 'clearance'\nclearance = 1e-4\nbearing_radius = 0.01\n"
        )
    Path("model.toml").write_text(text)
    for words in (
        ["check", "model.toml"],
        ["run", "model.toml", "-o", "out", "--figures"],
        ["info", "out"],
        ["export", "out", "out.nc"],
    ):
        done = command(*words)
        assert done.exit_code == 0, (words, done.stderr, done.exception)
        for name in ("[/]", r"$\frac{1$"):
            assert name in done.stdout or words[0] == "export"
    assert len(list(Path("out/figures").glob("*.png"))) >= 2
    assert r"$\frac{1$.force.max" in json.loads(Path("out/summary.json").read_text())["measures"]
    result = vfife.load_result("out")
    for page in (
        result._repr_html_(),
        result.record.assembly.mechanism._repr_html_(),
    ):  # what a notebook shows
        assert "<script>" not in page
        assert "<b>&%s" not in page
        assert "&lt;" in page  # hostile names are shown, escaped
    for name, figure in result.plot("mechanism", "forces").items():
        figure.savefig(f"{name}.svg")  # outside of what sets the style
    if clear:
        done = command(
            "compare",
            "model.toml",
            "--contact",
            "lankarani-nikravesh,hertz",
            "--turns",
            0.2,
            "-o",
            "compared",
        )
        assert done.exit_code == 0 and "[/]" in done.stdout, (done.stderr, done.exception)
        assert "[/]" in Path("compared/compare.csv").read_text()
    assert {path.name for path in Path().iterdir() if path.suffix != ".svg"} <= {
        "model.toml",
        "out",
        "out.nc",
        "compared",
    }
    assert {path.name for path in Path("..").iterdir() if path.name.startswith("x")} == set()


HOSTILE = (
    "<script>alert(1)</script>",
    "../x",
    "a/b",
    "nul\x00",
    "\u202eevil",
    "\x1b[31mred",
    "new\nline",
    "{0}",
    "%s",
    "-o",
    "x" * 3000,
)


@pytest.mark.system("every command with names of every kind")
@pytest.mark.parametrize("place", ["name", "body", "joint"])
@pytest.mark.parametrize("name", HOSTILE, ids=lambda name: repr(name[:12]))
def test_any_name_is_text_or_is_told(command: Callable, name: str, place: str) -> None:
    """Whatever it is made of: it is shown as it is, or refused in a sentence, and no file bears it."""
    quoted = json.dumps(name).replace("\\u0000", "\\u0000")
    if place == "name":
        text = CRANK.replace('name = "slider-crank"', f"name = {quoted}")
    elif place == "joint":
        text = CRANK.replace("[joint.P]", f"[joint.{quoted}]")
    else:
        text = CRANK.replace("[body.rod]", f"[body.{quoted}]").replace('"rod.', f'"{json.dumps(name)[1:-1]}.')
    Path("model.toml").write_text(text, encoding="utf-8")
    short = ["run", "model.toml", "-o", "out", "--json", "--loop", "interpreted", "--duration", "1e-4"]
    for words in (["check", "model.toml", "--long"], ["check", "model.toml", "--json"], short):
        done = command(*words)
        assert done.exit_code in (0, 2) and "Traceback" not in done.output, (done.exception, done.stderr)
        assert "\x1b" not in done.output and "\x00" not in done.output and "\u202e" not in done.output
        if done.exit_code == 2:
            assert "model.toml" in done.stderr
    if Path("out").exists():
        page = vfife.load_result("out").record.assembly.mechanism._repr_html_()
        assert "<script>" not in page
        vfife.load_result("out").plot("mechanism")
    assert {path.name for path in Path().iterdir()} <= {"model.toml", "out"}


def test_a_picture_of_an_own_law_stays_where_it_is_asked_for() -> None:
    for name in ("../x", "/etc/x", "a b", "..", "$x$"):
        assert (
            law_drawing.target_of(None, name).parent == Path()
            and law_drawing.target_of(None, name).suffix == ".png"
        )


def test_a_page_in_which_a_mechanism_runs(command: Callable) -> None:
    """Names end neither the script that has them nor the page's title; the browser's side writes them as
    text.
    """
    name = "</script><script>alert(1)</script>"
    text = CRANK.replace('name = "slider-crank"', f"name = {json.dumps(name)}").replace(
        "[joint.P]", f"[joint.'{name}']"
    )
    Path("model.toml").write_text(
        text.replace("[body.rod]", f"[body.'{name}']").replace('"rod.', f'"{name}.')
    )
    done = command("live", "model.toml", "-o", "page.html", "--no-sliders")
    assert done.exit_code == 0, (done.stderr, done.exception)
    page = Path("page.html").read_text()
    assert (
        "alert(1)" in page
        and "<script>alert" not in page
        and "</script><script>" not in page.replace("</script>\n<script>", "")
    )
    for script in (Path(vfife.__file__).parent / "live" / "browser").glob("*.js"):
        assert "innerHTML" not in script.read_text() and "insertAdjacentHTML" not in script.read_text(), (
            script.name
        )


def test_a_page_does_not_take_the_place_of_the_model(command: Callable) -> None:
    Path("model.toml").write_text(CRANK)
    for name in ("model.toml", "page", "page.txt"):
        done = command("live", "model.toml", "-o", name)
        assert done.exit_code == 2 and "the name of a page ends in .html" in done.stderr, done.stderr
    assert Path("model.toml").read_text() == CRANK and [path.name for path in Path().iterdir()] == [
        "model.toml"
    ]

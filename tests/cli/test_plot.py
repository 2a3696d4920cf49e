"""`vfife plot`: which figures, into which files, and what is not replaced."""

import os
import re
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from vfife import plots
from vfife.cli.commands import result as of_the_command
from vfife.cli.commands.result import run_names
from vfife.plots.catalogue import FIGURES
from vfife.store.folder import PICTURES, is_own

HEADS = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}


def test_the_command_knows_the_formats() -> None:
    assert set(of_the_command.PICTURES) == set(plots.PICTURES) == set(PICTURES)


@pytest.mark.usefixtures("unrendered")
def test_figures_that_are_there_are_replaced_with_force_only(command: Callable, case_c_run: Path) -> None:
    """And none is drawn where one of them is there."""
    line = ["plot", case_c_run, "--figure", "energy", "--figure", "traces", "-o", "drawn"]
    done = command(*line[:4], "-o", "drawn")
    assert done.exit_code == 0 and done.stdout == "drawn/energy.png\n" and "More:" not in done.stderr
    Path("drawn/energy.png").write_bytes(b"mine")
    again = command(*line)
    assert again.exit_code == 2 and "energy.png; name another folder with -o, or add --force" in again.stderr
    assert Path("drawn/energy.png").read_bytes() == b"mine" and os.listdir("drawn") == ["energy.png"]
    assert command(*line, "--force").stdout == "drawn/traces.png\ndrawn/energy.png\n"
    assert Path("drawn/energy.png").read_bytes().startswith(HEADS["png"])


def pictured(path: str) -> list[str]:
    """The lines of a drawing without its date and its names of parts."""
    return re.findall(r'<path d="([^"]*)"', Path(path).read_text())


@pytest.mark.parametrize(
    ("texts", "count", "names"),
    [
        (["new,worn, old"], 3, ["new", "worn", "old"]),
        (["new", "worn,old"], 3, ["new", "worn", "old"]),
        (["big-end 80 µm, small-end 32 µm", "new"], 2, ["big-end 80 µm, small-end 32 µm", "new"]),
        (["new, as built"], 1, ["new, as built"]),
        ([], 2, []),
    ],
)
def test_names_of_runs_have_commas_between_them(texts: list[str], count: int, names: list[str]) -> None:
    """A name with a comma stays whole where each run has its own option."""
    assert run_names(texts, count) == names


def test_commands_of_one_run_name_the_command_that_overlays_runs(command: Callable) -> None:
    for name in ("report", "animate"):
        done = command(name, "a", "b")
        said = " ".join(done.stderr.replace("│", " ").split())
        assert done.exit_code == 2 and "is of one run. vfife plot RUN RUN overlays runs" in said, said


def test_several_runs_are_overlaid(command: Callable, case_c_run: Path) -> None:
    line = ["plot", case_c_run, case_c_run, "--figure", "forces,phase", "--label", "new", "--label", "worn"]
    done = command(*line, "-o", "both")
    assert done.exit_code == 0 and done.stdout == "both/forces.png\nboth/phase.png\n"
    svg = command(*line[:3], "--figure", "forces", "--label", "new", "--label", "worn <&>", "-o", "f.svg")
    assert svg.stdout == "f.svg\n" and Path("f.svg").read_bytes().startswith(HEADS["svg"])
    commas = command(*line[:3], "--figure", "forces", "--label", "new, worn <&>", "-o", "g.svg")
    assert commas.exit_code == 0 and pictured("g.svg") == pictured("f.svg")
    usual = command("plot", case_c_run, case_c_run)
    folder = case_c_run.with_name(f"{case_c_run.stem}-and-{case_c_run.stem}")
    assert usual.stdout.splitlines()[0] == f"{folder}/orbits.png"
    assert "Not overlaid: mechanism (drawn of one run at a time)" in usual.stderr
    again = command("plot", case_c_run, case_c_run)
    assert again.exit_code == 2 and "there are figures already" in again.stderr
    for options, words in (
        (["--at", "90deg"], "the mechanism is drawn at a moment of one run"),
        (["--label", "new"], "these are 1 for 2 runs"),
        (["--label", "new,worn,old"], "these are 3 for 2 runs"),
        (["--figure", "strip", "-o", "other"], '"strip" is not overlaid'),
    ):
        wrong = command("plot", case_c_run, case_c_run, *options)
        assert wrong.exit_code == 2 and words in wrong.stderr and not Path("other").exists()


@pytest.mark.parametrize("kind", HEADS)
def test_formats(command: Callable, case_c_run: Path, kind: str) -> None:
    """A file says who made it, so that a later run into its folder knows it for its own."""
    done = command("plot", case_c_run, "--figure", "phase", "--format", kind, "-o", "drawn")
    path = Path(f"drawn/phase.{kind}")
    assert done.stdout == f"{path}\n" and path.read_bytes().startswith(HEADS[kind])
    assert is_own(path, None)
    path.write_bytes(HEADS[kind] + b", drawn by hand")
    assert not is_own(path, None)


def test_one_figure_as_one_file(command: Callable, case_c_run: Path) -> None:
    assert command("plot", case_c_run, "--at", "90deg", "-o", "quarter.svg").stdout == "quarter.svg\n"
    assert "four-bar, case c, crank at 90°, 10 ms" in Path("quarter.svg").read_text(encoding="utf-8")
    again = command("plot", case_c_run, "--at", "90deg", "-o", "quarter.svg")
    assert again.exit_code == 2 and "add --force to replace it" in again.stderr
    several = command("plot", case_c_run, "-o", "all.pdf")
    assert (
        several.exit_code == 2
        and "one file holds one figure and this draws 5" in several.stderr
        and not Path("all.pdf").exists()
    )


def test_the_list_says_what_there_is_and_what_the_run_has_nothing_for(
    command: Callable, case_c_run: Path
) -> None:
    done = command("plot", case_c_run, "--figure", "list")
    said = " ".join(done.stdout.split())
    assert (
        done.exit_code == 0
        and all(name in said for name in FIGURES)
        and not (case_c_run / "figures").exists()
    )
    assert "none: no link is elastic" in said and "usual" in said


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (("--figure", "energi"), 'there is no figure "energi": did you mean "energy"?'),
        (
            ("--figure", "guides"),
            'nothing for the figure "guides": no block has clearance in a guide; there are mechanism, orbits',
        ),
        (("--figure", "waterfall"), "it takes 3 turns"),
        (("--format", "jpg"), "--format jpg: figures have no such format; allowed: png, svg, pdf"),
        (("--at", "1 kg"), "neither an angle nor a time"),
        (("--at", "90deg", "--figure", "forces"), "name no other figure with it"),
    ],
)
def test_what_cannot_be_drawn_is_told(
    command: Callable, case_c_run: Path, given: tuple[str, ...], says: str
) -> None:
    done = command("plot", case_c_run, *given, "-o", "drawn")
    assert done.exit_code == 2 and says in done.stderr and not Path("drawn").exists()


@pytest.mark.usefixtures("unrendered")
def test_a_disk_that_is_full_keeps_what_is_drawn(
    command: Callable, case_c_run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    done = command("plot", case_c_run, "--figure", "phase", "-o", "drawn")
    assert done.exit_code == 5 and "The run is unchanged, and so are existing files." in done.stderr
    assert not os.listdir("drawn")


@pytest.mark.system("draws figures more slowly")
def test_while_figures_are_drawn(held: Callable, case_c_run: Path, tmp_path: Path) -> None:
    process = held("matplotlib", "plot", case_c_run, "-o", "drawn")
    process.send_signal(signal.SIGINT)
    _, err = process.communicate("on\n", timeout=60)
    assert (
        process.returncode == 130
        and err == "interrupted: Stopped by Ctrl-C. The run is unchanged, and no figure was drawn.\n"
    )
    assert not (tmp_path / "drawn").exists()


@pytest.mark.usefixtures("unrendered")
def test_stopped_after_the_first(
    command: Callable, case_c_run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept, drawn = plots.figure, []

    def stop(result: object, name: str, *rest: object) -> object:
        if drawn:
            raise KeyboardInterrupt
        drawn.append(name)
        return kept(result, name, *rest)

    monkeypatch.setattr(plots, "figure", stop)
    done = command("plot", case_c_run, "--figure", "phase,energy", "-o", "drawn")
    assert (
        done.exit_code == 130 and "The run is unchanged; 1 of 2 figures were drawn, in drawn." in done.stderr
    )
    assert os.listdir("drawn") == ["phase.png"]

"""``vfife sensitivity``: which numbers of a model matter."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .options import JsonOption, LawsOption, ModelArgument, SetOption, read_model
from .progress import ProgressLine
from .run import Companions, Duration, ForceStep, Quiet, Step, Turns, Yes
from .slopecost import told_of
from .targets import refuse_inputs
from .terminal import grid, output, print_json, row, sentences, tell, writing

if TYPE_CHECKING:
    from ..results.derivatives import Sensitivity

Of = Annotated[
    list[str] | None,
    typer.Option(
        "--of", metavar="MEASURE", help="Measures, * for any signs.", show_default="*.force.max, *.torque.max and *.angular_acceleration.max"
    ),
]
To = Annotated[list[str] | None, typer.Option("--to", metavar="PATH", help="Numbers of the model, * for any signs.", show_default="all")]
Top = Annotated[int, typer.Option("-n", "--top", metavar="N", min=1, help="So many numbers of each measure.")]
Runs = Annotated[
    int | None,
    typer.Option("--runs", metavar="N", help="So many runs with displaced steps, 1 to 8, have their mean taken.", show_default="2 with contact"),
]
Figure = Annotated[Path | None, typer.Option("--figure", metavar="FILE.png|svg|pdf", help="Draw them as bars.", show_default=False)]
Table = Annotated[Path | None, typer.Option("--csv", metavar="FILE.csv", help="Write all of them as a table.", show_default=False)]
WIDE = 0.05  # of the largest elasticity of a measure: from which on it is told how far displaced runs lie apart
ENDINGS = (".png", ".svg", ".pdf")


def sensitivity(
    model: ModelArgument,
    of: Of = None,
    to: To = None,
    top: Top = 8,
    set_: SetOption = None,
    laws: LawsOption = None,
    step: Step = None,
    turns: Turns = None,
    duration: Duration = None,
    companions: Companions = None,
    runs: Runs = None,
    force_step: ForceStep = False,
    figure: Figure = None,
    csv: Table = None,
    yes: Yes = False,
    as_json: JsonOption = False,
    quiet: Quiet = False,
) -> None:
    """Which number matters? The derivative of every measure by every number of the model, from one run that carries its derivatives along.

    Told are elasticities: by how many per cent a measure changes with one per cent of a number. Measures are of the last turn.
    """
    with sentences(str(model)):
        for option, path, endings in (("--figure", figure, ENDINGS), ("--csv", csv, (".csv",))):
            if path is not None and (path.suffix.lower() not in endings or not path.absolute().parent.is_dir()):
                what = f"ending in {' or '.join(endings)}, in a folder that is there"
                raise ValueError(f"{option} {path}: this is no file {what}; name one")
        refuse_inputs((("--figure", figure), ("--csv", csv)), (model, *(laws or ())))
        mechanism = read_model(model, set_, laws)
        told_of(mechanism, to or ["*"], step, turns, duration, runs, force_step, yes, quiet)
        from ..study.derivatives import sensitivity as sensitive

        length: dict[str, Any] = {"turns": turns, "duration": duration, "step": step}
        beside: int | str | None = int(companions) if companions is not None and companions.isdecimal() else companions
        with ProgressLine(quiet) as line:
            found = sensitive(mechanism, of or None, to or ("*",), companions=beside, runs=runs, force_step=force_step, progress=line, **length)
    if csv is not None:
        with writing(str(csv)):
            found.write_csv(csv)
    if figure is not None:
        with writing(str(figure)):
            from ..plots.files import saved_in_style
            from ..plots.tornado import tornado

            saved_in_style(lambda: tornado(found), figure)
    if as_json:
        left_out = {"refused": found.refused, "rounding": sorted(found.rounding)}
        print_json({"model": found.mechanism, "part": found.part, **left_out, "rows": found.rows()})
    elif not quiet:
        show(found, top)


def show(found: Sensitivity, top: int) -> None:
    """A table for people: of each measure the numbers that matter most."""
    from rich.text import Text

    console = output()
    title = f"{found.mechanism}: what its measures depend on"
    table = grid("measure", "value", "number", "per cent by 1 %", "from, to", title=title, right=(1, 3, 4))
    for name, value in found.measures.items():
        if name in found.doubtful:
            row(table, name, f"{value:.5g}", "companions part", "?", "")
            continue
        ranked = [item for item in found.ranked(name) if item[1]][:top]
        for k, (path, elastic) in enumerate(ranked):
            low, high = found.span(name, path)
            span = f"{low:.3g}, {high:.3g}" if high > low else ""
            mark = "" if found.known(name, path) else " ?"
            row(table, name if k == 0 else "", f"{value:.5g}" if k == 0 else "", path, f"{elastic:+.3g}{mark}", span)
    console.print(table)
    told = "; from, to are over displaced runs, and ? is where they differ in sign" if any(one.displaced for one in found.derivatives) else ""
    console.print(Text(f"Measures are of the {found.part}, in SI units{told}."))
    if found.doubtful:
        tell("note", f"companions of the run part in {', '.join(sorted(found.doubtful))}: derivatives of these mean nothing.")
    if found.rounding:
        tell("note", f"left out as rounding beside the largest of their unit: {', '.join(sorted(found.rounding))}.")
    wide = {name: spread for name in found.measures if name not in found.doubtful and (spread := found.spread(name)) > WIDE}
    if wide:
        most = max(wide, key=wide.__getitem__)
        what = f"displaced runs lie apart by up to {100.0 * wide[most]:.0f} % of the largest elasticity of {most}"
        tell("note", f"{what}: a smaller --step tells it more closely.")
    for path, why in found.refused.items():
        if not why.startswith("zero"):
            tell("note", f"{path}: {why}")

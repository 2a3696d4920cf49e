"""``vfife sensitivity``: which numbers of a model matter."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..job.progress import ProgressLine
from .options import JsonOption, LawsOption, ModelArgument, SetOption, read_model
from .run import Companions, Duration, ForceStep, Quiet, Step, Turns, Yes
from .slopecost import told_of
from .targets import refuse_inputs
from .terminal import grid, output, print_json, row, sentences, tell, writing

if TYPE_CHECKING:
    from ..results.derivatives import Effect, Sensitivity

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
LEAST = 1e-6  # per cent by one per cent: smaller effects are rounding
WIDE = 0.05  # of the largest derivative of a measure: width of a range from which on there is a note
NOTES = {
    "change": "* change for 1 %: the derivative does not describe it.",
    "unknown": "? sign or order of magnitude not known: changes of 1 % differ with their direction or with the size of the step.",
}
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
    """Which number matters? The derivative of every measure by every number of the model, checked by finite changes of the number.

    Shown are elasticities: by how many per cent a measure changes with one per cent of a number. Measures are of the last turn. Each number is also
    changed by 1 % and 0.1 %, both ways, and all of it is repeated with steps 1.4, 1.7 and 2 times as long. The range of an elasticity covers what
    these runs differ by. Where finite changes contradict the derivative, the change for 1 % and its range stand in its place; where the sign is not
    known, a question mark.
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
            from ..plots.style import saved_in_style
            from ..plots.tornado import tornado

            saved_in_style(lambda: tornado(found), figure)
    if as_json:
        left_out = {"refused": found.refused, "rounding": sorted(found.rounding)}
        print_json({"model": found.mechanism, "part": found.part, **left_out, "rows": found.rows()})
    elif not quiet:
        show(found, top)


def cells(one: Effect) -> tuple[str, str]:
    """The value of an effect and its range, which is left out where it has the same digits."""
    span = f"{one.low:.3g}, {one.high:.3g}" if one.high > one.low and len({f"{end:.3g}" for end in one[2:]}) > 1 else ""
    if one.kind == "unknown":
        return "?", span
    return f"{one.value:+.3g}{' *' if one.kind == 'change' else ''}", span


def show(found: Sensitivity, top: int) -> None:
    """A table for people: of each measure the numbers that matter most."""
    from rich.text import Text

    console = output()
    title = f"{found.mechanism}: what its measures depend on"
    table = grid("measure", "value", "number", "per cent by 1 %", "from, to", title=title, right=(1, 3, 4))
    shown: set[str] = set()
    for name, value in found.measures.items():
        if name in found.doubtful:
            row(table, name, f"{value:.5g}", "companions part", "?", "")
            continue
        effects = [one for one in found.effects(name) if max(abs(one.low), abs(one.high)) > LEAST][:top]
        shown |= {one.kind for one in effects}
        for k, one in enumerate(effects):
            first = (name, f"{value:.5g}") if k == 0 else ("", "")
            row(table, *first, one.path, *cells(one))
    console.print(table)
    for text in (f"Measures are of the {found.part}, in SI units.", *(NOTES[kind] for kind in ("change", "unknown") if kind in shown)):
        console.print(Text(text))
    if found.doubtful:
        tell("note", f"companions of the run part in {', '.join(sorted(found.doubtful))}: derivatives of these mean nothing.")
    if found.rounding:
        tell("note", f"left out as rounding beside the largest of their unit: {', '.join(sorted(found.rounding))}.")
    wide = {name: spread for name in found.measures if name not in found.doubtful and (spread := found.spread(name)) > WIDE}
    if wide:
        most = max(wide, key=wide.__getitem__)
        what = f"ranges of derivatives are up to {100.0 * wide[most]:.0f} % of the largest wide ({most})"
        tell("note", f"{what}: a smaller --step makes them narrower.")
    for path, why in found.refused.items():
        if not why.startswith("zero"):
            tell("note", f"{path}: {why}")

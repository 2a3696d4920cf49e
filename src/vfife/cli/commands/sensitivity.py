"""``vfife sensitivity``: which numbers of a model matter."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from ..job import FIGURES, CommandJob, refuse_endings
from ..options import JsonOption, LawsOption, ModelArgument, SetOption, read_model, refuse_inputs
from ..signals import NOTHING
from ..terminal import answer, sentences, writing
from .run import Companions, Duration, ForceStep, Quiet, Step, Turns, Yes

Of = Annotated[
    list[str] | None,
    typer.Option(
        "--of",
        metavar="MEASURE",
        help="Measures, * for any signs.",
        show_default="*.force.max, *.torque.max and *.angular_acceleration.max",
    ),
]
To = Annotated[
    list[str] | None,
    typer.Option("--to", metavar="PATH", help="Numbers of the model, * for any signs.", show_default="all"),
]
Top = Annotated[int, typer.Option("-n", "--top", metavar="N", min=1, help="So many numbers of each measure.")]
Runs = Annotated[
    int | None,
    typer.Option(
        "--runs",
        metavar="N",
        help="So many runs with displaced steps, 1 to 8, have their mean taken.",
        show_default="2 with contact",
    ),
]
Figure = Annotated[
    Path | None,
    typer.Option("--figure", metavar="FILE.png|svg|pdf", help="Draw them as bars.", show_default=False),
]
Table = Annotated[
    Path | None,
    typer.Option("--csv", metavar="FILE.csv", help="Write all of them as a table.", show_default=False),
]


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
    """Which number matters? The derivative of every measure by every number of the model, checked by finite
    changes of the number.

    Shown are elasticities: by how many per cent a measure changes with one per cent of a number. Measures are
    of the last turn. Each number is also changed by 1 % and 0.1 %, both ways, and all of it is repeated with
    steps 1.4, 1.7 and 2 times as long. The range of an elasticity covers what these runs differ by. Where
    finite changes contradict the derivative, the change for 1 % and its range stand in its place; where the
    sign is not known, a question mark.
    """
    with sentences(str(model)):
        refuse_endings((("--figure", figure, FIGURES), ("--csv", csv, (".csv",))), in_folder=True)
        refuse_inputs((("--figure", figure), ("--csv", csv)), (model, *(laws or ())))
        mechanism = read_model(model, set_, laws)
        from ...studies.methods.derivatives import sensitivity as sensitive

        length: dict[str, Any] = {"turns": turns, "duration": duration, "step": step}
        beside: int | str | None = (
            int(companions) if companions is not None and companions.isdecimal() else companions
        )
        job = CommandJob("sensitivity", Path(), yes=yes, quiet=quiet, saved=NOTHING)
        with job.at_work(str(model)):
            found = sensitive(
                mechanism,
                of or None,
                to or ("*",),
                companions=beside,
                runs=runs,
                force_step=force_step,
                progress=job,
                **length,
            )
    if csv is not None:
        with writing(str(csv)):
            found.write_csv(csv)
    if figure is not None:
        with writing(str(figure)):
            from ...plots.sensitivity import tornado
            from ...plots.style import saved

            saved(tornado(found), figure)
    if as_json or not quiet:
        from ...report import sensitivity as answers

        answer(answers.sensitivity(found, top), as_json)

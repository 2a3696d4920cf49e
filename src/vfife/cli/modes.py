"""``vfife modes``: natural frequencies of a mechanism about its start, and of its elastic links."""

from __future__ import annotations

from typing import Annotated

import typer

from .options import JsonOption, LawsOption, ModelArgument, SetOption, read_model
from .terminal import answer, sentences

Count = Annotated[int, typer.Option("-n", "--count", metavar="N", min=1, help="So many of the lowest.")]
Released = Annotated[bool, typer.Option("--released", help="Without drivers, which otherwise hold what they drive.")]


def modes(
    model: ModelArgument,
    set_: SetOption = None,
    count: Count = 10,
    released: Released = False,
    laws: LawsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Natural frequencies and shapes about the start: of the whole mechanism, and of its elastic links by themselves.

    Shapes are in the JSON value: displacement (m, m, rad) of every particle, in the order of the particles of a result, the ground first.
    """
    with sentences(str(model)):
        mechanism = read_model(model, set_, laws)
        from ..analysis.modes import modes as found_modes

        found = found_modes(mechanism, count, released=released)
    from ..report import vibration

    answer(vibration.modes(mechanism, found), as_json)

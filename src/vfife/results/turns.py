"""The latest turns of a run laid over each other: every channel by turn and crank angle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..analysis.turns import part_of
from ..errors import VfifeError
from ..solvers.repeating import LONGEST, outputs_of_a_turn

if TYPE_CHECKING:
    import xarray

    from .view import View


def latest_turns(view: View) -> xarray.Dataset:
    """The channels of a run over ``turn`` and ``crank_angle``, shape (turns, outputs of a turn, ...): the turns that its measures are of, and the
    last eight at least, as far as there are so many.

    A turn is counted from 1 and ends where the next one begins; its angle (degrees) is that from the last whole turn of the crank before its begin.
    Raises VfifeError where there is no whole turn of a crank at constant speed, or the step does not divide it.
    """
    said, outputs, angle = view.motion, outputs_of_a_turn(view.record.assembly), view.crank_angle
    if said is None or outputs is None or angle is None:
        raise VfifeError(
            f"{view.name}: there are no turns to lay over each other: that takes a crank at constant speed, a run of a turn at the least, and a "
            'step that divides a turn ("auto" does); result.data has all of the run over time'
        )
    first = min(said.first, max(1, said.count - LONGEST + 1))
    numbers = np.arange(first, said.count + 1)
    window = slice((first - 1) * outputs + 1, said.count * outputs + 1)
    begin = angle[(said.count - 1) * outputs]
    over = angle[(said.count - 1) * outputs + 1 : said.count * outputs + 1] - 360.0 * np.floor(begin / 360.0 + 1e-6)
    data = view.data.isel(time=window).drop_vars(("time", "crank_angle"), errors="ignore")
    time = view.time[window].reshape(len(numbers), outputs)
    shaped = {name: one for name, one in data.variables.items() if "time" in one.dims}
    found = data.drop_dims("time").assign_coords(
        turn=("turn", numbers, {"units": "1", "long_name": "turn of the run, counted from 1"}),
        crank_angle=("crank_angle", over, {"units": "deg", "long_name": f"angle of {view.crank}"}),
        time=(("turn", "crank_angle"), time, {"units": "s", "long_name": "time"}),
    )
    dims = ("turn", "crank_angle")
    found = found.assign({
        str(name): ((*dims, *one.dims[1:]), one.values.reshape(len(numbers), outputs, *one.shape[1:]), one.attrs) for name, one in shaped.items()
    })  # fmt: skip
    return found.assign_attrs(motion=said.motion, measures_of=part_of(view.record, said))

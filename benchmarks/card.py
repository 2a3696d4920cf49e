"""Members on a graphics card: how many steps a second all of them make, beside one lane of a core of the same
machine.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from measure import EXAMPLES, Options, Part, interleaved, seconds, table

from vfife import load_model
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import Assembly, bounds, limited_rows
from vfife.assembly.reassemble import reassembled
from vfife.compiler.runtime.cuda import DeviceStream, card
from vfife.compiler.runtime.runner import Started, Starter, Stream
from vfife.errors import DeviceError
from vfife.solvers.record import recorded_rows

MEMBERS = (1_000, 10_000, 100_000)
KINDS = 64  # clearances among them
STEPS, ONE = 2_000, 100_000  # that are timed, of each member on the card, of the one on the core
SETTLED = 5_000  # steps before, in which play is first crossed


def measure(options: Options) -> Part:
    """Case c with clearances of 0.1 to 0.5 mm."""
    try:
        card()
    except DeviceError as error:
        return Part(notes=[f"card: {error}"])
    base = assemble(load_model(EXAMPLES / "four_bar_case_c.toml"), turns=1000)
    made = [of_play(base, 1e-4 * (1.0 + 4.0 * k / KINDS)) for k in range(KINDS)]
    rounds = 1 if options.quick else 3
    one = filled(Stream, base, made, 1)
    alone = interleaved(rounds, {"one": lambda: seconds(lambda: one.advance(ONE)) / ONE})["one"]
    rates, rows = {}, []
    for members in MEMBERS[: 1 if options.quick else None]:
        stream = filled(DeviceStream, base, made, members)
        begun = stream.lanes  # fewer where its memory is small
        spent = interleaved(rounds, {"all": lambda stream=stream: seconds(lambda: stream.advance(STEPS))})[
            "all"
        ]
        rates[begun] = begun * STEPS / spent
        rows.append((f"{begun:,}", f"{rates[begun]:.3g}", f"{alone * rates[begun]:.0f}"))
    ratios = {f"card.members_{members}": alone * rate for members, rate in rates.items()}
    told = table("card", "members", "steps a second", "of one lane's", rows=rows)
    return Part(ratios, {"ns_of_one_lane": 1e9 * alone, "steps_a_second": rates}, [told])


def of_play(base: Assembly, clearance: float) -> Assembly:
    """The base with another clearance in all joints."""
    return reassembled(
        base,
        {
            name: dataclasses.replace(joint, clearance=clearance)
            for name, joint in base.mechanism.clearances.items()
        },
    )


def filled(
    kind: type[Stream | DeviceStream], base: Assembly, made: list[Assembly], members: int
) -> Stream | DeviceStream:
    """A stream with members in all its lanes, past their first steps, that nothing stops before the end."""
    kept, parts = recorded_rows(base), base.mechanism.settings.parts
    stream = kind(
        base.topology, members, "generated", kept[:1], 1, kept, limited_rows(base), base.tables.size, parts
    )
    starter = Starter(base.topology, 1, "generated", base.tables.size, parts)
    begun: list[Started] = [starter.started(one.state, one.tables, np.stack(bounds(one))) for one in made]
    for lane in range(stream.lanes):
        stream.put(lane, begun[lane % len(begun)], 2**40, 1)
    stream.advance(SETTLED)
    return stream

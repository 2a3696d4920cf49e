"""The assembled mechanism in a run file: names, integers, parameters and the start, so that reading a run assembles nothing.

The state is kept block by block under the blocks' names: a later order of rows, and blocks that come or go, do not matter.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import forms
from ..assembly.assembled import Assembly, BodyMap, StepChoice
from ..errors import RunFileError
from ..kernels.arrays import Layout
from ..kernels.blocks import BY_NAME
from ..kernels.topology import Topology
from ..kinematics.mobility import Mobility
from ..laws import ContactLaw, FrictionLaw
from ..model.mechanism import Mechanism
from ..solvers.record import lasting_blocks, lasting_rows

NAMES = ("contacts", "ideals", "pivots", "springs", "contact_joints", "notes", "shared")
OF_LAWS = ("contact_laws", "friction_laws", "contact_form", "friction_form")  # follow from the laws that the model names

# Names of blocks in run files of version 0.1 and before.
OLD_ENTITIES = {"clearance": "contact", "ideal": "joint", "element": "frame", "row": "constraint"}
OLD_NAMES = {
    "clearance_contact": "contact_slots",
    "clearance_clearance_steps": "contact_duration",
    "clearance_contact_steps": "contact_duration",
    "contact_contact_steps": "contact_duration",
}
COUNTED = frozenset(name for name, now in OLD_NAMES.items() if now == "contact_duration")  # in steps; a duration is in seconds


def present_name(name: str) -> str:
    """What a block is called today; run files keep the names of their time."""
    if name in BY_NAME:
        return name
    entity, _, rest = name.partition("_")
    return OLD_NAMES.get(name) or f"{OLD_ENTITIES.get(entity, entity)}_{rest}"


def kept_assembly(assembly: Assembly) -> dict[str, Any]:
    """What a run file's meta keeps of an assembly: ``assembly`` for JSON, ``start`` and ``tables`` as arrays."""
    mobility, blocks = assembly.mobility, lasting_blocks(assembly.layout)
    topology = {field.name: getattr(assembly.topology, field.name) for field in dataclasses.fields(Topology) if field.name not in OF_LAWS}
    told = {
        "topology": topology,
        "blocks": [(name, len(rows)) for name, rows in blocks],
        "bodies": [dataclasses.asdict(body) for body in assembly.bodies.values()],
        "mobility": None if mobility is None else dataclasses.asdict(mobility),
        **{name: getattr(assembly, name) for name in NAMES},
    }
    return {"assembly": told, "start": assembly.state[lasting_rows(assembly.layout)], "tables": assembly.tables}


def assembly_of(meta: Mapping[str, Any], mechanism: Mechanism, choice: StepChoice, where: str) -> Assembly:
    """The assembly of which a file kept the parts; ``where`` names the file in messages. Raises RunFileError where they do not fit."""
    told = _tuples(meta["assembly"])
    joints = [mechanism.contacts[name] for name in told["contact_joints"]]
    contact = forms(ContactLaw, [joint.contact for joint in joints])
    friction = forms(FrictionLaw, [joint.friction for joint in joints])
    topology = Topology(
        **_known(Topology, told["topology"]),
        contact_laws=contact,
        friction_laws=friction,
        contact_form=tuple(contact.index(joint.contact.form()) for joint in joints),
        friction_form=tuple(friction.index(joint.friction.form()) for joint in joints),
    )
    layout = Layout(topology)
    bodies = {body["name"]: BodyMap(**_known(BodyMap, body)) for body in told["bodies"]}
    mobility = None if told["mobility"] is None else Mobility(**_known(Mobility, told["mobility"]))
    names = {name: told.get(name, ()) for name in NAMES}
    state = state_of(layout, told["blocks"], meta["start"], where)
    return Assembly(mechanism, topology, layout, state, meta["tables"], bodies, choice=choice, mobility=mobility, **names)


def state_of(layout: Layout, blocks: Iterable[tuple[str, int]], values: NDArray[np.float64], where: str) -> NDArray[np.float64]:
    """S from its blocks; a block of today that was not there is zero, one that is not there any more is left out."""
    state, at = np.zeros(layout.rows), 0
    for name, count in blocks:
        now = present_name(name)
        rows = layout.rows_of(now) if now in BY_NAME else None
        if at + count > len(values) or (rows is not None and len(rows) != count):
            raise RunFileError(f"{where}: the state has {count} numbers for {name}, which does not fit the model; run the model again")
        if rows is not None:
            state[rows] = values[at : at + count]
        at += count
    return state


def _known(kind: type[Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Values of the fields that a class has today."""
    return {field.name: values[field.name] for field in dataclasses.fields(kind) if field.name in values}


def _tuples(value: Any) -> Any:
    """JSON's lists as the tuples that they were."""
    if isinstance(value, list):
        return tuple(_tuples(one) for one in value)
    return {key: _tuples(one) for key, one in value.items()} if isinstance(value, dict) else value

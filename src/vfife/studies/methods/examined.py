"""A mechanism examined before a run, in Python: what ``vfife check`` tells of a file."""

from __future__ import annotations

from ...assembly.assemble import assemble
from ...assembly.possible import outlook
from ...model.mechanism import Mechanism
from ...model.validation import validate
from ...report.check import Checked
from ...report.check import checked as summarised
from ...simulation.start import expected_forces, first_contact_steps, ideal_of, referred

BRIEF = 1_000_000  # steps of an ideal mechanism that need no patience


def checked(mechanism: Mechanism) -> Checked:
    """Examines a mechanism; the step is that with which :func:`~vfife.simulation.simulate.simulate` begins,
    which follows from the forces that the joints of the ideal mechanism carry. Where that takes more than a
    million steps the contact laws alone set it.

    Raises ModelError with every fault, AssemblyError where no position satisfies its joints or it jams on its
    way.
    """
    validate(mechanism)
    seen = outlook(mechanism)
    ideal = ideal_of(mechanism) if seen.through else None
    expected = expected_forces(referred(ideal if ideal is not None and ideal.choice.steps <= BRIEF else None))
    begin = first_contact_steps(mechanism, mechanism.settings.companions)
    return summarised(assemble(mechanism, expected=expected, contact_steps=begin), seen.notes)

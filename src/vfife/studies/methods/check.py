"""``vfife check`` in Python: a mechanism is checked before a run."""

from __future__ import annotations

from ...assembly.assemble import assemble
from ...assembly.possible import outlook
from ...model.mechanism import Mechanism
from ...model.validation import validate
from ...report.check import Checked
from ...report.check import checked as summarised
from ...simulation.start import expected_forces, first_contact_steps, ideal_of, referred

BRIEF = 1_000_000  # steps of an ideal mechanism, which take about a second


def checked(mechanism: Mechanism) -> Checked:
    """Check a mechanism. The step is that with which :func:`~vfife.simulation.simulate.simulate` begins.

    It follows from the forces in the joints of the ideal mechanism, or where that takes more than a million
    steps, from the contact laws alone.

    Raises ModelError with every fault, AssemblyError where no position satisfies its joints or it jams on its
    way.
    """
    validate(mechanism)
    motion = outlook(mechanism)
    ideal = ideal_of(mechanism) if motion.passes else None
    expected = expected_forces(referred(ideal if ideal is not None and ideal.choice.steps <= BRIEF else None))
    begin = first_contact_steps(mechanism, mechanism.settings.companions)
    return summarised(assemble(mechanism, expected=expected, contact_steps=begin), motion.notes)

"""``vfife check`` in Python: a mechanism is checked before a run."""

from __future__ import annotations

from ...model.mechanism import Mechanism
from ...model.validation import validate
from ...report.check import Checked
from ...report.check import checked as summarised
from ...simulation.start import examination


def checked(mechanism: Mechanism) -> Checked:
    """Check a mechanism. The step is that with which :func:`~vfife.simulation.simulate.simulate` begins, as
    far as an :func:`~vfife.simulation.start.examination` knows it.

    Raises ModelError with every fault, AssemblyError where no position satisfies its joints or it jams on its
    way.
    """
    validate(mechanism)
    facts = examination(mechanism)
    return summarised(facts.assembly, facts.outlook.notes)

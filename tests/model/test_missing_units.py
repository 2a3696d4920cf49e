"""A length, inertia or speed whose unit is missing is refused or cautioned about, in every shipped model;
nothing is said of random mechanisms.
"""

from pathlib import Path

import pytest

import loose_sample
import vfife
from vfife import gallery
from vfife.errors import Fault, VfifeError
from vfife.files import GALLERY
from vfife.model.mechanism import Mechanism
from vfife.model.validation import faults
from vfife.model.validation.plausibility import suspects
from vfife.modelfile.parameter import number_at, numbers, with_values
from vfife.modelfile.read import load

TEMPLATES = Path(vfife.__file__).parent / "modelfile" / "templates"
FILES = [GALLERY / f"{name}.toml" for name in gallery.__all__] + sorted(TEMPLATES.glob("*.toml"))
# From the units of drawings to those of a model: mm, mm^2, mm^4, kg mm^2 and mm/s.
MISSING_UNITS = {"m": 1e3, "m^2": 1e6, "m^4": 1e12, "kg m^2": 1e6, "m/s": 1e3}
# A small number among larger ones, or among those of its own list, may be meant a thousand times larger.
PLAUSIBLE = {
    "squeezer": {"body.K1.center.0", "body.K2.position.1"},
    "williams_toggle": {"body.toggle.nodes.apex.1"},
}


def is_told(m: Mechanism, path: str, value: float) -> bool:
    try:
        changed = with_values(m, {path: value})
    except (VfifeError, Fault):
        return True
    return bool(faults(changed) or suspects(changed))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_length_inertia_and_speed_without_its_unit_is_told(file: Path) -> None:
    m = load(file)
    assert suspects(m) == ()
    silent, compared = set(), 0
    for path, value in numbers(m).items():
        place = number_at(m, path.split("."))
        if place is not None and value and (factor := MISSING_UNITS.get(place[2].unit)):
            compared += 1
            if not is_told(m, path, factor * value):
                silent.add(path)
    assert compared and silent == PLAUSIBLE.get(file.stem, set())


@pytest.mark.parametrize("kind", loose_sample.KINDS)
def test_nothing_is_said_of_random_mechanisms(kind: str) -> None:
    for seed in range(loose_sample.EACH):
        assert suspects(loose_sample.drawn(kind, seed).m) == ()

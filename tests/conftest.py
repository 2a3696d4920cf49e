"""No test is judged by time; laws that a test registers do not stay."""

from collections.abc import Iterator

import pytest
from hypothesis import settings

from vfife.laws import ContactLaw, FrictionLaw

settings.register_profile("calm", deadline=None)
settings.load_profile("calm")


@pytest.fixture
def only_built_in_laws() -> Iterator[None]:
    """Laws of a test do not stay in the registries, which other tests go through."""
    before = dict(ContactLaw.registry), dict(FrictionLaw.registry)
    yield
    for law, kept in zip((ContactLaw, FrictionLaw), before, strict=True):
        law.registry.clear()
        law.registry.update(kept)

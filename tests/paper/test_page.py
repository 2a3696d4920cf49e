"""The page of the paper lists each parameter once: items name the earlier item that shares most of theirs."""

from __future__ import annotations

from vfife_validation.paper.contents import Item, Parameter
from vfife_validation.paper.page import page

SPEED = Parameter("crank speed", "50π rad/s", "stated", "section 5")
FRICTION = Parameter("friction", "0.1", "inferred", "Table 3")
LENGTH = Parameter("axial length", "5 mm", "inferred", "Table 3")
SLOWER = Parameter("crank speed", "10π rad/s", "stated", "section 5")


def shown(*items: Item) -> list[str]:
    """The sections of a page, without its head."""
    return page(items, lambda chart: "").replace("\u00a0", " ").split("<section")[1:]


def test_an_item_lists_only_what_differs_from_an_earlier_one() -> None:
    first = Item("fig1", "Fig. 1: forces", parameters=(SPEED, FRICTION, LENGTH))
    slower = Item("fig2", "Fig. 2: forces", parameters=(SLOWER, FRICTION, LENGTH))
    same = Item("fig3", "Fig. 3: orbits", parameters=(SLOWER, FRICTION, LENGTH))
    one, two, three = shown(first, slower, same)
    assert all(value in one for value in ("50π rad/s", "0.1", "5 mm"))
    assert '<a href="#fig1">Fig. 1</a>, except:' in two and "10π rad/s" in two and "5 mm" not in two
    assert '<a href="#fig2">Fig. 2</a>.' in three and "<table" not in three


def test_parameters_that_an_item_lacks_are_named() -> None:
    first = Item("fig1", "Fig. 1", parameters=(SPEED, FRICTION, LENGTH))
    fewer = Item("fig2", "Fig. 2", parameters=(SPEED, LENGTH))
    assert "without friction." in shown(first, fewer)[1]


def test_an_item_that_shares_little_lists_all() -> None:
    first = Item("fig1", "Fig. 1", parameters=(SPEED, FRICTION, LENGTH))
    other = Item("fig2", "Fig. 2", parameters=(SLOWER, LENGTH))
    assert "Parameters as for" not in shown(first, other)[1] and "5 mm" in shown(first, other)[1]

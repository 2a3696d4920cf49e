"""The items by name, in the paper's order."""

from __future__ import annotations

from collections.abc import Callable

from .beyond import beyond
from .claims import claims
from .contents import Item
from .context import Context
from .impact import fig8, fig9, fig10
from .infer import infer
from .one_joint import fig12, fig13
from .three_joints import fig15, fig16, fig17, fig18, fig19, fig20, table3, table4

ITEMS: dict[str, Callable[[Context], Item]] = {
    item.__name__: item
    for item in (
        fig8,
        fig9,
        fig10,
        fig12,
        fig13,
        fig15,
        fig16,
        fig17,
        table3,
        fig18,
        fig19,
        fig20,
        table4,
        claims,
        infer,
        beyond,
    )
}


def make(name: str, context: Context) -> Item:
    """Return an item, computed once in a context."""
    item: Item = context.compute_once(name, lambda: ITEMS[name](context))
    return item

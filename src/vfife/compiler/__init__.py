"""The step as code: traced into data, ordered, written as text of a language, compiled, kept, run.

``source`` gathers the data-driven text, and ``plain`` writes it for LLVM; ``trace`` and ``traceable`` turn a
step into data, ``straight_line`` that of one topology, ``tangent`` its derivative; ``schedule`` orders it;
``llvm``, ``gpu``, ``python`` and ``javascript`` write it, ``modules`` with the loop driver. ``native``
compiles it for this processor, ``gpu`` to PTX; ``cache`` stores the code; ``loops`` and ``runner`` run it,
``cuda`` on a graphics card.
"""

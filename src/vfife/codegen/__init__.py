"""The step as code: traced into data, ordered, written as text of a language, compiled, kept, run.

``source`` gathers the data-driven text; ``trace`` and ``traceable`` make a step data, ``straight_line`` for one topology, ``schedule`` orders it;
``llvm``, ``python`` and ``javascript`` write it; ``native`` and ``compile`` make machine code, ``cache`` keeps it, ``runner`` runs it.
"""

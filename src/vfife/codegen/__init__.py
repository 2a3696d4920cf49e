"""The step as code: traced into data, ordered, written as text of a language, compiled, kept, run.

``source`` gathers the data-driven text; ``trace`` and ``traceable`` make a step data, ``straight_line`` for one topology, ``schedule`` orders it;
``llvm``, ``gpu``, ``python`` and ``javascript`` write it; ``native``, ``compile`` and ``ptx`` make code of it, ``cache`` keeps it, ``runner`` runs
it, ``ondevice`` on a graphics card that ``cuda`` reaches.
"""

"""The step as code: traced into data, written as text of a language, compiled, stored and run.

- :mod:`~vfife.compiler.trace`: the data-driven text (``source``); a step as data (``tape``, ``traceable``,
  ``straight_line``), its order (``graph``, ``schedule``) and its derivative (``tangent``).
- :mod:`~vfife.compiler.backends`: that data as text of LLVM (``llvm``), graphics cards (``gpu``), JavaScript
  and Python; plain functions as text of LLVM (``plain``, ``expressions``, ``kinds``); ``modules`` has the
  loop driver.
- :mod:`~vfife.compiler.runtime`: machine code (``native``), PTX (``ptx``) and its ``cache``; loops and
  streams that call it (``loops``, ``runner``, ``cuda``), and laws by themselves (``lawloops``).
"""

"""Validation of vfife: cases with answers from elsewhere (``vfife verify``) and the source paper computed
anew (``vfife paper``).

It is installed with vfife and uses it as a user does. Nothing in vfife imports it, but for those two
commands.
"""

"""Sealed files of runs, studies, maps, wear and fits; locks and run folders."""

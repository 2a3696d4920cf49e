"""What advances an assembled mechanism: transient runs chunk by chunk, equilibria, ensembles; the record they
leave.
"""

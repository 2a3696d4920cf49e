"""Results: series with units, tables, spectra, comparisons, fits; conversion of runs to files and back."""

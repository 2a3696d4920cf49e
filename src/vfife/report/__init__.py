"""Documents of answers: sentences, tables, terminal output and pages from numbers."""

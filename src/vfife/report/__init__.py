"""Numbers to words, tables and pages."""

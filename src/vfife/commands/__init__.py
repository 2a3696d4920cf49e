"""The commands of the command line, one file for one or two of them."""

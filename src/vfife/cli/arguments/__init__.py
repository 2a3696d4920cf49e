"""Arguments and options of the commands, which load at once."""

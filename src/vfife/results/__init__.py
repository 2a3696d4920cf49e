"""What survives a process: channels with units, run files and folders, where a run came from, how it goes on."""

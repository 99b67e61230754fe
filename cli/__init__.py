"""The command line: the only place where messages are printed and exit codes are set."""

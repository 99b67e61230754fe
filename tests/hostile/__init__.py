"""Result files made bad in every way, and every command that reads one: `python -m tests.hostile --help`."""

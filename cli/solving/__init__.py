"""Commands that solve problems."""

"""The shipped problems in, each solved and verified beside its published value; tables, and what got worse, out."""

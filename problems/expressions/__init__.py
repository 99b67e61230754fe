"""The text of an expression in; a function of named values out."""

"""The paper's examples in; its figures, its numbers and a page that shows them out."""

LIBRARY = "library"
"""What stands for all shipped problems among the names of examples: `results.library`."""

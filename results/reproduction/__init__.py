"""The paper's examples in; its figures, its numbers and a page that shows them out."""

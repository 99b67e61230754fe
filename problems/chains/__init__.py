"""`model: {kind: chain, ...}` in, the same file with its states, residuals, expressions and drawing written out."""

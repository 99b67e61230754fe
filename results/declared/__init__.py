"""Nothing in; what a result file must hold out, and what of an open one is not so."""

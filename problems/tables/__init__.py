"""Points and values in, also from a CSV file; a smooth function of one, two or three arguments out."""

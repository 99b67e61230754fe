"""A Spec in; what each name means, and where each expression stands, out."""

"""A Spec in; every mistake and warning that concerns more than one value out."""

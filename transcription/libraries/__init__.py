"""Names of the libraries that are slow to load -> the same, loaded without what they bring and nobody here needs."""

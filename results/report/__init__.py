"""A result, or the folder of a sweep, in; one page that needs no network out."""

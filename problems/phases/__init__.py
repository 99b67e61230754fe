"""Several phases in one file: what each of them is by itself, and what connects them."""

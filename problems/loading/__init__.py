"""A document in, plain data that the schema can validate out: written out, completed, its options refused or not."""

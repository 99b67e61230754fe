"""What is told of problems that cannot be solved."""

"""What costs less at the start than the standard library has it."""

"""What is slow to make, and what it is made of -> the same, read from the cache folder of the user."""

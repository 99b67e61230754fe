"""What the dynamics of a phase keep by themselves, and equations that say what others say already."""

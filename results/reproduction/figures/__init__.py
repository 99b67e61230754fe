"""The figures of the paper and of the introduction, one file for each example: its solves, numbers and pictures."""

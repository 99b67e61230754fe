"""Transcription: a continuous problem and a mesh -> a nonlinear program -> a trajectory and its error."""

"""An Outcome in; functions of time, costates, error estimates and causes of failure out."""

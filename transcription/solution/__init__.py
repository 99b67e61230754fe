"""An Outcome in; functions of time, costates, error estimates, the error bar and sensitivities out."""

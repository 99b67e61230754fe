"""Problem files: YAML text -> Spec -> Problem, the continuous optimal control problem.

Notation, here and in every package of trajopt, is that of Kelly, SIAM Review 59(4), 2017 ("the paper"): t is time,
x the states, u the controls, p the static parameters, f the dynamics dx/dt = f(t, x, u, p), w the integrand of the
objective, h_k the duration of segment k, epsilon the error in the dynamics between collocation points and eta its
integral over a segment.
"""

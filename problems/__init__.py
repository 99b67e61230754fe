"""Problem files: YAML text -> Spec -> Problem, the continuous optimal control problem.

Notation, here and in every package of trajopt, is that of Kelly, SIAM Review 59(4), 2017 ("the paper"): t is time,
x the states, u the controls, p the static parameters, f the dynamics dx/dt = f(t, x, u, p), w the integrand of the
objective, h_k the duration of segment k, epsilon the error in the dynamics between collocation points and eta its
integral over a segment.
"""

import os

# Read when NumPy and IPOPT load their BLAS, and this package is what everything of trajopt imports first. A thread for
# each core only slows the small dense blocks of these problems: MUMPS, and shooting most of all.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

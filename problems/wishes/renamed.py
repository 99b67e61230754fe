"""Keys by the names that they have elsewhere, where the value is the same."""

from __future__ import annotations

_BOUNDS = {
    "lower": "min minimum lb lower_bound lbound low least",
    "upper": "max maximum ub upper_bound ubound high most",
}
_CONDITION = {**_BOUNDS, "expression": "expr function formula", "equals": "equal eq value"}
RENAMED = {
    "file": {
        "parameters": "params param constants constant consts const",
        "expressions": "definitions aliases intermediate intermediates auxiliary",
        "states": "state state_variables",
        "controls": "inputs input control control_variables actuators",
        "optimize": "static static_parameters design_parameters free_parameters unknowns decision",
        "objective": "cost costs cost_function objective_function goal criterion loss",
        "constraints": "subject_to events boundary_conditions path_constraints boundary_constraints conditions",
        "guess": "guesses initial_guess initialization init warm_start",
        "solver": "options ipopt solver_options nlp nlp_options",
        "links": "linkages linkage linkage_constraints",
        "phases": "phase stages",
        "scaling": "scale scales scaling_factors",
        "tables": "table lookups",
        "continuation": "homotopy",
    },
    "time": {
        "initial": "t0 t_0 start begin from initial_time t_initial",
        "final": "tf t_f T end stop to final_time t_final duration length horizon",
    },
    "state": {
        "rate": "dxdt dot derivative deriv der ode equation eq dynamics xdot dx rhs expression expr f",
        "accel": "ddot acceleration second_derivative xddot",
        "initial": "start x0 begin from ic initial_value",
        "final": "end xf to goal target final_value stop",
        **_BOUNDS,
    },
    "control": _BOUNDS,
    "static": {**_BOUNDS, "guess": "initial init start value x0"},
    "end": {**_BOUNDS, "value": "equals equal fixed"},
    "objective": {"minimize": "minimise min", "maximize": "maximise max"},
    "terms": {
        "integral": "lagrange running running_cost stage stage_cost integrand path integrated",
        "terminal": "mayer final end endpoint terminal_cost end_cost final_cost boundary",
    },
    "constraints": {
        "path": "inequality inequalities equality equalities nonlinear trajectory",
        "boundary": "terminal final initial event events endpoint boundary_conditions ends",
        "integral": "isoperimetric integrals",
    },
    "constraint": _CONDITION,
    "link": {
        **_CONDITION,
        "from": "first start before phase",
        "to": "second end after next",
        "except": "without but",
    },
    "pair": {"a": "gap distance first x lhs", "b": "force second y rhs", "relax": "relaxation epsilon eps mu"},
    "measured": {
        "deviations": "sigma sigmas std stdev error errors uncertainty uncertainties noise se sd",
        "weights": "w",
        "data": "values samples points",
        "file": "csv path filename",
        "compare": "columns expression expressions model outputs",
    },
    "mesh": {
        "segments": "nodes intervals N n points steps elements num_segments n_segments num_intervals",
        "degree": "order colpoints collocation_points points_per_segment polynomial_degree",
        "method": "scheme transcription",
        "tolerance": "tol",
    },
    "refine": {"tolerance": "tol error eps", "max_meshes": "max_iter iterations max_iterations meshes"},
    "guess": {},
    "table": {
        "points": "x grid breakpoints abscissa abscissae knots inputs",
        "values": "y z data ordinates outputs table",
        "kind": "interp interpolation method type interpolant spline",
        "outside": "extrapolate extrapolation clamp bounds fill_value",
        "file": "csv path filename",
    },
}
"""Kind of mapping -> a key of it -> words that mean the same elsewhere."""

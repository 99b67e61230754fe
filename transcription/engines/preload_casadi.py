"""CasADi's IPOPT, loaded: a fork server whose children shall have it imports this module before all others.

Importing it has an effect, so nobody else does.
"""

from __future__ import annotations

from .ipopt_library import CASADI, load_library

load_library(CASADI)

"""Values of results as JSON can hold them."""

from __future__ import annotations

from typing import Any

import numpy as np


def for_json(value: Any) -> Any:
    """The same without NumPy's types, and None for numbers that are not finite: what JSON can hold."""
    if isinstance(value, dict):
        return {str(key): for_json(item) for key, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [for_json(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value

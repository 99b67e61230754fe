"""Models in Python: dynamics too long for a problem file. `find_model` imports a model only when it is asked for."""

from __future__ import annotations

from importlib import import_module

from ..errors import Mistake, SpecError
from ..text import did_you_mean
from .model import Model

MODELS = {"five_link_biped": "five_link_biped"}
"""Name of each shipped model -> its module here, which holds it as MODEL."""


def find_model(name: str) -> Model:
    """The shipped model of that name. Raises SpecError, with the name most like it, if there is none."""
    if name not in MODELS:
        remedy = did_you_mean(name, MODELS, always=f"the models are {', '.join(MODELS)}")
        raise SpecError(Mistake("model", f'there is no model "{name}"', remedy))
    model: Model = import_module(f".{MODELS[name]}", __package__).MODEL
    return model

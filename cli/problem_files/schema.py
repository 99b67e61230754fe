"""`trajopt schema`: the JSON Schema of problem files."""

from __future__ import annotations

import json

from ..errors import command


@command
def schema() -> None:
    """Print the JSON Schema of problem files.

    Example: trajopt schema > trajopt.schema.json

    Editors and validators use it to complete and check a file while it is written.
    """
    from ...problems.language.json_schema import schema as json_schema
    from ...transcription.schemes.table import METHODS

    print(json.dumps(json_schema(tuple(METHODS)), indent=2))

"""A Spec in; every place where the units of a file do not fit together out. Only `trajopt check` asks for it."""

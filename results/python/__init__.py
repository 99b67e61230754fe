"""What Python users work with: a problem file, a name or a text in; solutions as functions of time out."""

"""Plain data in; a Spec with every field checked and every default filled in out."""

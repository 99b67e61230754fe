"""A problem file and what is varied in it -> many solved cases, in a folder that loses none of them."""

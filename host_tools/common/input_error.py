"""What the host tools end with where input cannot be used: one line on stderr, exit code 2."""


class InputError(Exception):
    """What is wrong with which file, in one line."""

"""The one error that a user's input may cause: a clear line and exit status 2, no traceback."""


class BadInput(ValueError):
    """Says where (file and key), what value, and what is allowed."""

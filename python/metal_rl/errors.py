"""Refusals that name the field, what was found and what is allowed."""

from metal_rl._core import MetalError


def refuse(field: str, message: str) -> MetalError:
    """The exception for a field that cannot be used."""
    error = MetalError(f"{field}: {message}")
    error.field = field
    return error

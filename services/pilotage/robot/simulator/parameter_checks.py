"""Checks that the parameter classes of the simulator share; pure."""


def refuse_negative(params: object) -> None:
    """Refuse parameters below zero; ValueError names the first."""
    for name, value in vars(params).items():
        if isinstance(value, int | float) and value < 0.0:
            raise ValueError(f"{name} must not be negative, it is {value:g}")


def refuse_zero(params: object, *names: str) -> None:
    """Refuse zero for these parameters; ValueError names the first."""
    for name in names:
        if not getattr(params, name):
            raise ValueError(f"{name} must be more than 0")


def refuse_shares_above_one(params: object, *names: str) -> None:
    """Refuse these parameters when their sum is above 1, as shares of a whole."""
    total = sum(getattr(params, name) for name in names)
    if total > 1.0:
        raise ValueError(f"{' and '.join(names)} must be 1 at most, they are {total:g}")

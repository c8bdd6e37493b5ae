"""The toy service `ben`."""

from toys.service import run

if __name__ == "__main__":
    raise SystemExit(run(__file__))

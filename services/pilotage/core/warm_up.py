"""Compiles every kernel once, so that no service pays for it while a robot waits.

Run by deploy/setup as `python -m pilotage.core.warm_up`.
"""


def main() -> None:
    """Call each kernel on the smallest input of the types it meets in service."""


if __name__ == "__main__":
    main()

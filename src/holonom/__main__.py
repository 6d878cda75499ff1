"""`python -m holonom` is the command `holonom`; it answers to Ctrl-C before it has loaded anything that takes time."""

import sys

from holonom.app.console.interrupts import quiet_process


def main() -> int:
    """Run the command line of this process; the exit status."""
    with quiet_process():
        from holonom.app.console.cli import main

        return main()


if __name__ == "__main__":
    sys.exit(main())

"""`python -m holonom` is the command `holonom`."""

import sys

from holonom.app.cli import main

sys.exit(main())

"""`python -m ggo_factors.cli` is `ggo`."""

import sys

from ggo_factors.cli import main

sys.exit(main())

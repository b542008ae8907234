"""``python -m halftone``."""

import sys

from halftone.cli import main

sys.exit(main())

"""The command without its script: ``python -m lipoid.fleet``."""

import sys

from lipoid.fleet.command import main

sys.exit(main())

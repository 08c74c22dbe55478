"""`python3 -m curvd_client` is the command curvd-client."""

import sys

from curvd_client.console import main

if __name__ == "__main__":
    sys.exit(main())

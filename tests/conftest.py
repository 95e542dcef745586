"""What all tests share."""

import os

# As the commands do, and before numpy is imported: two workers with two threads each would only wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

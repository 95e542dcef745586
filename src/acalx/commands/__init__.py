"""The command line: the only place that knows Hydra."""

import os

# Before numpy is imported: on matrices as small as these a second thread of the linear algebra only waits for the
# first, and where the other core is busy, with another job of a sweep perhaps, a call takes a hundred times as long.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

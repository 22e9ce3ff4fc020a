"""Runs a command and writes what it took, as JSON: processor time in seconds, and the most memory in MiB.

usage: python3 -I -S measured.py RESULT COMMAND ...

A process of its own, and a small one: Linux counts what the parent held as memory of a child that has just begun.
"""

import json
import os
import sys

pid = os.posix_spawnp(sys.argv[2], sys.argv[2:], os.environ)
_, status, usage = os.wait4(pid, 0)
with open(sys.argv[1], "w") as file:
    json.dump({"s": usage.ru_utime + usage.ru_stime, "mib": usage.ru_maxrss / 1024}, file)
sys.exit(os.waitstatus_to_exitcode(status))

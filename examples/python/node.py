"""A node in Python, in a process of its own."""

import sys

import catan

try:
    client = catan.Client()
    for run in client.runs("detect"):
        found = sum(i * i for i in range(10000))  # in the place of real work
        if run.number % 10 == 0:
            run.skip_output()  # nothing found
except catan.Error as error:
    sys.exit("node.py: %s" % error)

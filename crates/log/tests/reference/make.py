"""Writes what other readers find in the logs of a folder, one line a topic:

    kind, file, topic, instance, messages, sum of all finite values of all fields

    python make.py DATA_FOLDER > counts.tsv        (pyulog 1.3.0, pymavlink 2.4.50)

Fields of text are left out, and of ULog the stamps, whose sums say nothing beside their size.
"""

import math
import sys
from pathlib import Path

import numpy as np
from pymavlink import DFReader
from pyulog import ULog


def ulog(path):
    for data in ULog(str(path)).data_list:
        total = 0.0
        for name, values in data.data.items():
            if name == "timestamp":
                continue
            values = values.astype(np.float64)
            total += math.fsum(values[np.isfinite(values)])
        yield data.name, data.multi_id, len(data.data["timestamp"]), total


def dataflash(path):
    reader = DFReader.DFReader_binary(str(path))
    found = {}
    while (message := reader.recv_msg()) is not None:
        entry = found.setdefault(message.get_type(), [0, []])
        entry[0] += 1
        letters = message.fmt.format
        for letter, name in zip(letters, message.fmt.columns):
            # The mode's number is told by name.
            if letter in "nNZMa":
                continue
            value = float(getattr(message, name))
            if math.isfinite(value):
                entry[1].append(value)
    for name, (count, values) in found.items():
        yield name, 0, count, math.fsum(values)


for path in sorted(Path(sys.argv[1]).rglob("*")):
    kind = {".ulg": ulog, ".bin": dataflash}.get(path.suffix)
    if kind:
        for name, instance, count, total in sorted(kind(path)):
            print(path.suffix[1:], path.name, name, instance, count, repr(total), sep="\t")

"""Makes the fixtures of the reading tests: pip install numpy==2.4.6 pyarrow==26.0.1; python make.py

Every file holds the same 12 rows of t, x, y, or says below how it differs.
"""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

t = np.arange(12) * 0.25
x = np.exp(-t)
y = np.sin(t)
table = np.column_stack([t, x, y])

np.save("c_order.npy", table)
np.save("fortran_order.npy", np.asfortranarray(table))
np.save("float32.npy", table.astype(np.float32))
np.save("big_endian.npy", table.astype(">f8"))
np.save("integers.npy", np.round(1000 * table).astype(np.int64))
np.save("one_dimension.npy", x)
np.save("cube.npy", np.zeros((2, 3, 4)))
np.save("complex.npy", table.astype(np.complex128))

columns = {
    # Time as a stamp in nanoseconds, 250 ms apart.
    "stamp": pa.array((1_700_000_000 * 10**9 + np.round(t * 1e9).astype(np.int64)).astype("datetime64[ns]")),
    "t": pa.array(t),
    # A null in row 5 (from 0).
    "x": pa.array(x, mask=np.arange(12) == 5),
    "y": pa.array(y.astype(np.float32)),
    "count": pa.array(np.arange(12, dtype=np.uint32)),
    "run": pa.array(["first"] * 6 + ["second"] * 6),
    "on": pa.array([True, False] * 6),
    "day": pa.array([20_000] * 12, type=pa.date32()),
    "list": pa.array([[1.0, 2.0]] * 12),
}
# Row groups of 5, 5 and 2 rows.
pq.write_table(pa.table(columns), "kinds.parquet", compression="snappy", row_group_size=5)
few = pa.table({name: columns[name] for name in ["t", "x"]})
for codec in ["zstd", "gzip", "lz4", "none"]:
    pq.write_table(few, f"{codec}.parquet", compression=codec, row_group_size=5)

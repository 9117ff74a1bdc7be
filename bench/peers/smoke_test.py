# SPDX-License-Identifier: Apache-2.0
"""One rendered frame through every peer that was built: all have times and sane labels. Usage: smoke_test.py BENCH_PEERS"""

import json
import subprocess
import sys

SEGMENTS_ALWAYS = {"cells", "fransac", "voxel-ransac", "rransac", "ransac"}


def main():
    command = [sys.argv[1], "--suite", "segment,planes,voxel_grid,floor", "--dataset", "synth", "--frames", "1", "--repeat", "1", "--json", "-"]
    document = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    rows = [row for row in document["rows"] if not row.get("note", "").startswith("not built")]
    complaints = []
    for row in rows:
        name = f"{row['suite']} {row['peer']}"
        if row.get("note", "").endswith(" s a run"):
            continue  # a slow rival on a slow machine
        if len(row["times_ms"]) != 1 or not 0 < row["times_ms"][0] < 60_000:
            complaints.append(f"{name}: times {row['times_ms']} {row.get('note', '')}")
        # A rendered empty room: whichever of its walls is found, most of its pixels are right.
        if row["suite"] == "segment" and not row.get("precision", 0) + row.get("best_f1", 0) > 0.8:
            complaints.append(f"{name}: F1 {row.get('best_f1')}")
        if row["suite"] == "planes" and row["library"] != "floor" and not 0 <= row.get("instance_f1_50", -1) <= 1:
            complaints.append(f"{name}: instance F1 {row.get('instance_f1_50')}")
        if row["suite"] == "voxel_grid" and not 100 < row.get("leaves", 0) < row["points"]:
            complaints.append(f"{name}: {row.get('leaves')} leaves")
    missing = SEGMENTS_ALWAYS - {row["peer"] for row in rows}
    if missing:
        complaints.append(f"missing: {sorted(missing)}")
    print("\n".join(complaints) or f"{len(rows)} rows")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())

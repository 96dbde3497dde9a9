"""Deform an object of a scene while it is touched: a swelling travels along a block, 30 shapes a second. Usage:
    deploy/run --scene scenes/swelling.toml     # in another terminal; prints HUB and KEY. Or start the three nodes with this scene
    PYTHONPATH=build/release/python python3 examples/swelling_block.py [SECONDS [HUB [KEY]]]"""
import os
import sys
import time

import numpy as np

import hapton

SECONDS, HUB, KEY = (sys.argv[1:] + ["60", "127.0.0.1", ""][len(sys.argv) - 1 :])[:3]
MESH = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "meshes", "supple_block.obj")
SHAPE_S = 1 / 30

rest = hapton.load_mesh(MESH, unit="mm", seal=False).vertices  # in metres, with the same order of vertices as in the scene
client = hapton.Client(HUB, KEY)
begin, given = time.monotonic(), 0
while time.monotonic() - begin < float(SECONDS):
    at = 0.045 * np.sin(1.5 * (time.monotonic() - begin))
    r = np.minimum(1.0, np.hypot(rest[:, 0] - at, rest[:, 1]) / 0.03)
    height = 0.012 * (1 - r**2) ** 2 * np.maximum(0.0, rest[:, 2] / 0.02)
    client.set_shape("block", np.column_stack([np.zeros((len(rest), 2)), height]), over_s=SHAPE_S)
    given += 1
    if why := client.take_shape_rejection():
        sys.exit(f"rejected: {why}")
    time.sleep(SHAPE_S)
takes_s = client.set_shape("block", np.zeros_like(rest), over_s=0.5, wait=True)  # wait: returns once the haptics node has this shape
print(f"{given} shapes given; back at rest in {takes_s:.2f} s")

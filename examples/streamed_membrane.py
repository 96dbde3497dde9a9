"""Feel a membrane that this program deforms: it solves a wave equation and makes 30 shapes a second. Usage:
    io_node &
    PYTHONPATH=build/release/python python3 examples/streamed_membrane.py [SECONDS [HUB]]
This program is the haptics node of the session. Push down in the middle of the workspace."""
import sys
import threading

import numpy as np

import hapton

SECONDS, HUB = (sys.argv[1:] + ["60", "127.0.0.1"][len(sys.argv) - 1 :])[:2]
N, SIDE_M, REACH_M = 13, 0.08, 0.008  # vertices along a side; length of a side; largest displacement of a vertex
FRAME_S = 1 / 30

x, y = np.meshgrid(np.linspace(-SIDE_M / 2, SIDE_M / 2, N), np.linspace(-SIDE_M / 2, SIDE_M / 2, N))
rest = np.column_stack([x.ravel(), np.zeros(N * N), -y.ravel()])  # horizontal, y is up
number = np.arange(N * N).reshape(N, N)
a, b, c, d = number[:-1, :-1].ravel(), number[:-1, 1:].ravel(), number[1:, 1:].ravel(), number[1:, :-1].ravel()
membrane = hapton.DeformStep(hapton.Mesh(rest, np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])), REACH_M,
                             hapton.Material(stiffness_n_per_m=400, damping_ns_per_m=0.5))
touched = {"at": None, "force_n": 0.0, "last_s": 0.0}


def force(hand):
    felt = membrane.step(hand.position_m, min(max(hand.t_s - touched["last_s"], 1e-4), 0.05))
    touched.update(at=felt["proxy_m"][0] if felt["contact"][0] else None, force_n=-felt["force_n"][0, 1], last_s=hand.t_s)
    return felt["force_n"][0]


def simulate(stop):
    """Simulates the height of each vertex and its rate of change. The edge is fixed, and the hand pushes the membrane down."""
    height, rate, shapes = np.zeros((N, N)), np.zeros((N, N)), 0
    while not stop.wait(FRAME_S):
        load = np.zeros((N, N))
        if touched["at"] is not None:
            far = np.hypot(x - touched["at"][0], -y - touched["at"][2])
            load = -4.0 * touched["force_n"] * np.exp(-((far / 0.012) ** 2))
        for _ in range(10):
            h = FRAME_S / 10
            padded = np.pad(height, 1, mode="edge")
            tension = padded[:-2, 1:-1] + padded[2:, 1:-1] + padded[1:-1, :-2] + padded[1:-1, 2:] - 4 * height
            rate += h * (2000.0 * tension + load - 6.0 * rate)
            height = np.clip(height + h * rate, -REACH_M, REACH_M)
            height[[0, -1], :] = height[:, [0, -1]] = 0.0
        membrane.set_shape(rest + np.column_stack([np.zeros(N * N), height.ravel(), np.zeros(N * N)]), over_s=FRAME_S)
        shapes += 1
    print(f"{shapes} shapes, the lowest vertex at {1e3 * height.min():.1f} mm")


stop = threading.Event()
simulation = threading.Thread(target=simulate, args=(stop,))
simulation.start()
try:
    report = hapton.run_haptics_node(force, seconds=float(SECONDS), hub=HUB)
finally:  # also if there is no hub, and after Ctrl-C, because Python waits for its threads before it ends
    stop.set()
    simulation.join()
print(f"{report['rate_hz']:.0f} forces a second")

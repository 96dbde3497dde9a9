"""Shows: a reaching task with eight targets on a circle. In every second trial a pulse pushes the hand aside. C++ computes the fields at the
device's rate. Python chooses the fields of each trial and keeps the states that it reads.
Run: io_node --rate 4000, and in another terminal: python3 reaching_task.py [TRIALS [HUB [FILE.npz]]]"""
import sys
import time

import numpy as np

import hapton
from hapton import fields

RADIUS_M = 0.05
REACHED_M = 0.006
LONGEST_S = 2.0


def target_of(trial):
    angle = 2 * np.pi * trial / 8
    return RADIUS_M * np.array([np.cos(angle), np.sin(angle), 0.0])


def fields_of(trial, target):
    """A plane to move in, a spring to the target, damping, and in every second trial the pulse."""
    plane = [fields.wall([0, 0, 0], [0, 0, 1], 600.0), fields.wall([0, 0, 0], [0, 0, -1], 600.0)]
    pulse = [fields.pulse([0, -2.0, 0], duration_s=0.1, delay_s=0.3)] if trial % 2 else []
    return plane + [fields.spring(target, 40.0, max_force_n=1.5), fields.viscous(2.0)] + pulse


def run_trial(node, trial):
    """Runs until the target is reached or the time is over. Returns rows of trial, t_s, x, y, z, fx, fy, fz."""
    target = target_of(trial)
    node.set(fields_of(trial, target))
    begin, rows = time.monotonic(), []
    while time.monotonic() - begin < LONGEST_S:
        now = node.state()
        rows.append([trial, now["t_s"], *now["position_m"], *now["force_n"]])
        if np.linalg.norm(now["position_m"] - target) < REACHED_M:
            break
        time.sleep(0.005)
    print(f"trial {trial}: {len(rows)} looks, ends {1e3 * np.linalg.norm(rows[-1][2:5] - target):.1f} mm from the target")
    return rows


def main():
    trials = int(sys.argv[1]) if len(sys.argv) > 1 else 16
    node = hapton.FieldNode(sys.argv[2] if len(sys.argv) > 2 else "127.0.0.1")
    rows = [row for trial in range(trials) for row in run_trial(node, trial)]
    state = node.state()
    node.close()
    print(f"{state['replies']} forces, {state['rate_hz']:.0f} a second, {state['superseded']} samples superseded, p99 {state['compute_p99_us']:.1f} us")
    if len(sys.argv) > 3:
        np.savez(sys.argv[3], trials=np.array(rows))


if __name__ == "__main__":
    main()

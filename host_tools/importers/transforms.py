"""Fixed transforms between named frames, as /tf_static gives them."""

import numpy as np


def rotation(q_wxyz):
    """Rotation matrix of a Hamilton quaternion, normalised here."""
    w, x, y, z = np.asarray(q_wxyz, float) / np.linalg.norm(q_wxyz)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])


def transform(R, p):
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, p
    return T


class TransformTree:
    def __init__(self):
        self.steps = {}  # frame -> {neighbour: T_frame_neighbour}

    def add(self, parent, child, q_wxyz, p):
        """p_parent = T p_child."""
        T = transform(rotation(q_wxyz), p)
        parent, child = parent.lstrip("/"), child.lstrip("/")
        self.steps.setdefault(parent, {})[child] = T
        self.steps.setdefault(child, {})[parent] = np.linalg.inv(T)

    def between(self, a, b):
        """T_ab, p_a = T_ab p_b, or None where no chain joins the two."""
        if not a or not b:
            return None
        reached, border = {a: np.eye(4)}, [a]
        while border:
            frame = border.pop()
            for neighbour, T in self.steps.get(frame, {}).items():
                if neighbour not in reached:
                    reached[neighbour] = reached[frame] @ T
                    border.append(neighbour)
        return reached.get(b) if a != b else np.eye(4)

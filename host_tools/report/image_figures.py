"""Residuals where they are in the image, and how they drift along tracks. Both show what a lens or a tracker does that the model
does not."""

import numpy as np
import plotly.graph_objects as go

import figures
from figures import Missing, member, styled

CELLS_ACROSS = 16
ARROW = "#1864ab"
FEWEST_TRACKS = 3      # in a cell, for a mean to say anything
FEWEST_DIFFERENCES = 30
LONG_ARROW = 0.9       # quantile; the few that are longer would make all others points


def columns(data, *names):
    """Columns of residuals.camera as arrays of the same length."""
    camera = member(data, "residuals", "camera")
    table = {name: figures.numbers(member(camera, name), 1, f"residuals.camera.{name}") for name in names}
    if len({len(column) for column in table.values()}) != 1:
        raise Missing("The columns of residuals.camera differ in length.")
    return table


def cameras_of(data):
    return sorted(set(columns(data, "camera")["camera"].astype(int).tolist()))


class Field:
    """Mean residual vector and chi2 per cell of the image of one camera."""

    def __init__(self, data, camera):
        c = columns(data, "camera", "track", "u", "v", "u_px", "v_px", "u_sigma", "v_sigma")
        mine = (c["camera"] == camera) & np.isfinite(np.stack(list(c.values()))).all(axis=0)
        c = {name: column[mine] for name, column in c.items()}
        if not len(c["u"]):
            raise Missing(f"cam{camera} has no residuals.")
        size = (data.get("images") or [[0, 0]] * (camera + 1))[camera]
        self.width, self.height = (max(s, float(np.ceil(x.max()))) for s, x in zip(size, (c["u"], c["v"])))
        self.cell = self.width / CELLS_ACROSS
        self.shape = (max(1, int(np.ceil(self.height / self.cell))), CELLS_ACROSS)
        column = np.clip((c["u"] / self.cell).astype(int), 0, self.shape[1] - 1)
        row = np.clip((c["v"] / self.cell).astype(int), 0, self.shape[0] - 1)
        index = row * self.shape[1] + column
        self.mean = np.stack([self.per_cell(index, c[name]) for name in ("u_px", "v_px")])
        self.chi2 = self.per_cell(index, (c["u_sigma"] ** 2 + c["v_sigma"] ** 2) / 2)
        # Points of a track share their error where it drifts: a mean counts as many independent ones as tracks.
        pairs = np.unique(np.stack([index, c["track"].astype(int)]), axis=1)[0]
        self.tracks = np.bincount(pairs, minlength=np.prod(self.shape)).reshape(self.shape)
        self.scatter = np.sqrt(np.mean(np.stack([c["u_px"], c["v_px"]]) ** 2))
        self.seen = self.tracks >= FEWEST_TRACKS

    def per_cell(self, index, values):
        n = np.prod(self.shape)
        with np.errstate(invalid="ignore"):
            return (np.bincount(index, values, n) / np.bincount(index, minlength=n)).reshape(self.shape)

    def standing_out(self):
        """(cells whose mean is beyond three of its standard errors in x or y, cells with a mean, as many by chance)."""
        far = (np.abs(self.mean) > 3 * self.scatter / np.sqrt(np.maximum(self.tracks, 1))).any(axis=0) & self.seen
        return int(far.sum()), int(self.seen.sum()), 0.0054 * int(self.seen.sum())

    def centres(self):
        return (np.arange(self.shape[1]) + 0.5) * self.cell, (np.arange(self.shape[0]) + 0.5) * self.cell

    def magnification(self):
        """Of the arrows: a number 1, 2 or 5 times a power of ten with which a long one is about a cell long."""
        lengths = np.sqrt((self.mean**2).sum(axis=0))[self.seen]
        raw = self.cell / max(np.quantile(lengths, LONG_ARROW) if len(lengths) else 0, 1e-9)
        power = 10.0 ** np.floor(np.log10(raw))
        return float(max(p for p in (1, 2, 5) if p * power <= raw) * power)


def add_arrows(drawing, field):
    """One trace of shafts and one of heads: a trace per arrow takes a browser seconds."""
    rows, columns = np.nonzero(field.seen)
    mean = field.mean[:, rows, columns]
    from_x, from_y = (centre[index] for centre, index in zip(field.centres(), (columns, rows)))
    to_x, to_y = np.stack([from_x, from_y]) + field.magnification() * mean
    gap = np.full(len(rows), np.nan)
    drawing.add_scatter(x=np.stack([from_x, to_x, gap], axis=1).ravel(), y=np.stack([from_y, to_y, gap], axis=1).ravel(), mode="lines",
                        line=dict(color=ARROW, width=1.5), showlegend=False, hoverinfo="skip")
    drawing.add_scatter(x=to_x, y=to_y, mode="markers", showlegend=False, hoverinfo="text",
                        hovertext=[f"{u:+.3f}, {v:+.3f} px from {n} tracks" for u, v, n in zip(*mean, field.tracks[rows, columns])],
                        marker=dict(symbol="arrow", size=7, color=ARROW, angle=np.degrees(np.arctan2(mean[0], -mean[1]))))


def residual_field(data, camera):
    field = Field(data, camera)
    x, y = field.centres()
    drawing = go.Figure(go.Heatmap(
        x=x, y=y, z=np.where(field.seen, np.round(field.chi2, 3), np.nan), zmin=0, zmax=3, colorscale="YlOrRd", hoverongaps=False,
        colorbar=dict(orientation="h", y=1.02, yanchor="bottom", thickness=12, title=dict(text="chi² per residual; 1: the stated noise", side="top")),
        hovertemplate="chi² %{z:.2f}<extra></extra>"))
    add_arrows(drawing, field)
    drawing.update_xaxes(title="image x [px]", range=[0, field.width], constrain="domain")
    drawing.update_yaxes(title="image y [px]", range=[field.height, 0], scaleanchor="x", scaleratio=1, constrain="domain", constraintoward="top")
    styled(drawing, 480)
    drawing.update_layout(margin=dict(t=90))
    return drawing


def field_sentence(data, camera):
    field = Field(data, camera)
    far, seen, chance = field.standing_out()
    return (f"Arrows: mean residual of a cell, {field.magnification():g} times as long. {far} of {seen} cells have a mean beyond three standard errors "
            f"({chance:.1f} by chance). Arrows that form a pattern say that the lens model lacks something.")


def drift(data):
    """Per lag: seconds, mean squared difference of residuals along tracks (px^2 per axis), its standard error over tracks."""
    c = columns(data, "t", "track", "u_px", "v_px")
    order = np.lexsort((c["t"], c["track"]))
    c = {name: column[order] for name, column in c.items()}
    starts = np.flatnonzero(np.diff(c["track"], prepend=np.nan))
    tracks = [slice(a, b) for a, b in zip(starts, [*starts[1:], len(order)])]
    out = []
    for lag in range(1, 40):
        seconds, squares = [], []
        for s in tracks:
            if s.stop - s.start > lag:
                step = [c[name][s][lag:] - c[name][s][:-lag] for name in ("t", "u_px", "v_px")]
                seconds.append(step[0].mean())
                squares.append(np.mean((step[1] ** 2 + step[2] ** 2) / 2))
        if len(squares) < FEWEST_DIFFERENCES:
            break
        out.append((np.mean(seconds), np.mean(squares), np.std(squares) / np.sqrt(len(squares))))
    if not out:
        raise Missing("too few tracks with several points.")
    return np.array(out)


def track_drift(data, noise):
    t, square, error = drift(data).T
    drawing = go.Figure(go.Scatter(x=figures.rounded(t, 3), y=figures.rounded(square, 5), mode="lines+markers", name="tracks",
                                   error_y=dict(type="data", array=figures.rounded(error, 5)), line=dict(color=figures.KEPT)))
    stated, found = ((noise.get(f"{kind}_white_px"), noise.get(f"{kind}_walk_px_per_sqrt_s")) for kind in ("stated", "track"))
    for (white, walk), name, color in ((stated, "as stated", figures.TRUTH), (found, "white noise and walk found", figures.AXES["x"])):
        if white:
            drawing.add_scatter(x=figures.rounded(t, 3), y=figures.rounded(2 * white**2 + walk**2 * t, 5), mode="lines", name=name,
                                line=dict(color=color, dash="dash", width=1.5))
    drawing.update_xaxes(title="lag along the track [s]", rangemode="tozero")
    drawing.update_yaxes(title="mean squared difference [px²]", rangemode="tozero")
    return styled(drawing, 380)

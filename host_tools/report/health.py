"""What happened, in plain words: status, cause, suspects, faults of the data. The top of the page of a replay."""

import words

# Counters that are faults, and how to say them. All others count what is usual.
FAULTS = {
    "imu_gaps": "Gaps in the IMU data, of more than three periods",
    "imu_saturated": "IMU samples at full scale, where the sensor saturates",
    "imu_spikes": "IMU samples that stand alone, one or two, far from their neighbours: left out, and the segment ends there",
    "imu_not_finite": "IMU samples that are no numbers",
    "imu_stamps_back": "IMU stamps that repeat or go back",
    "imu_stamps_far": "IMU stamps more than a second from their neighbours",
    "frame_stamps_back": "Image stamps that repeat or go back",
    "frame_stamps_far": "Images more than two seconds from the newest IMU sample, so of another clock, or with a stamp ahead of those that follow",
    "frames_dropped": "Images missing, by the gaps between the others",
    "frames_few_tracks": "Images with fewer than eight corner tracks",
    "points_not_finite": "Corner points that are no numbers",
    "points_repeated": "Corner points that came twice in an image",
    "clock_restarts": "Times that the IMU's clock was set anew",
    "filter_restarts": "Times that the odometry lost its way and began anew",
    "segments_discarded": "Segments with too few keyframes or landmarks",
    "segments_unsettled": "Segments that contradict their own IMU data or did not fit",
    "segments_outdated": "Segments dropped: newer ones contradict them, so that the device has changed, or they were condensed before a calibration that failed",
    "segments_missed": "Segments that ended while a calibration was under way and were left out",
    "points_left_out": "Corner points left out since they lie far from where the model has them",
}
DISAGREE = 2.0  # variance of what segments say, over that of stated noise


def fit_sentence(result):
    ratio = words.chi2_per_dof(result)
    if ratio is None:
        return None
    size = "as large as" if 0.8 <= ratio <= 1.25 else "larger than" if ratio > 1.25 else "smaller than"
    scale = (result.get("fit") or {}).get("noise_scale")
    more = f"; all sigmas are scaled by {scale:.2f}" if words.is_number(scale) and scale > 1.1 else ""
    if more and scale**2 > 1.1 * ratio:
        more += ", since segments disagree by more"
    return f"Residuals are {size} their stated noise: chi²/dof {ratio:.2f}{more}."


def health_sentences(health):
    frames, used = health.get("frames_offered") or health.get("frames"), health.get("frames_used")
    if words.is_number(frames) and words.is_number(used):
        yield f"The odometry followed {words.plain(used)} of {words.plain(frames)} images."
    scatter = health.get("segment_scatter")
    if words.is_number(scatter) and scatter > DISAGREE:
        yield f"Segments disagree among themselves: their variance is {scatter:.1f} times what the noise explains, which is in the sigmas."


def fault_sentences(counts):
    for name, text in FAULTS.items():
        n = counts.get(name)
        if words.is_number(n) and n > 0:
            yield f"{text}: {words.plain(n)}."


def suspect_sentences(result):
    for suspect in (result.get("health") or {}).get("suspects") or []:
        text = str(suspect.get("words") or suspect.get("name") or "")
        if text and text not in (result.get("cause") or ""):
            held = "; the sigmas hold what it would move" if suspect.get("in_sigmas") else ""
            yield f"Suspect: {text.rstrip('.')}{held}."


def note_sentences(result):
    for note in [*((result.get("health") or {}).get("notes") or []), *(result.get("changes") or [])]:
        text = str(note.get("words") or "")
        if text and text not in (result.get("cause") or ""):
            yield f"Note: {text.rstrip('.')}."


def sentences(result, counts):
    """The first one is the verdict."""
    yield words.headline(result)
    if result.get("cause"):
        cause = str(result["cause"]).rstrip(".")
        yield cause[:1].upper() + cause[1:] + "."
    yield from suspect_sentences(result)
    yield from note_sentences(result)
    yield from filter(None, [fit_sentence(result)])
    yield from health_sentences(result.get("health") or {})
    found = list(fault_sentences(counts))
    yield from found or ["No faults in the data were counted."]


def origin(result):
    """Which device, log and program, in a line."""
    logs = [str(log.get("name")) for log in result.get("logs") or []]
    parts = [f"device {result['device_id']}" if result.get("device_id") else "", ", ".join(logs[:4]) + (" ..." if len(logs) > 4 else ""),
             f"segcal {result['library_version']}" if result.get("library_version") else ""]
    return " · ".join(filter(None, parts))

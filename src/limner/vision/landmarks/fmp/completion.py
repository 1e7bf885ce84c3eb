"""Annotated faces in; those that a model can learn from, with all landmarks, out, and why the others cannot."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from limner.vision.landmarks.fmp.dataset import Sample, similarity, transform

STILL = np.array([27, 28, 29, 30, 33, *range(36, 48)])
"""Landmarks that an expression moves least."""

MOST_YAW_DEG = 30.0
"""A face that a machine annotated is not learned from when it is turned farther: half of it hides the landmarks."""

LEAST_EYE_PX = 40.0
"""Nor when the outer eye corners are nearer, since a cell of the model would then be a pixel or two."""


def completed(samples: Sequence[Sample]) -> tuple[list[Sample], list[str]]:
    """Choose what to learn from, and fill in landmarks that are not known from another photo of the same person.

    They are those of the other photo, laid over by the similarity that best fits nose and eyes.

    Returns:
        The samples with all landmarks known, in their order, and one line for each that is refused.
    """
    whole = {sample.person: sample for sample in samples if sample.known.all() and not sample.machine}
    result, left_out = [], []
    for sample in samples:
        reason = _refusal(sample)
        if not reason and sample.known.all():
            result.append(sample)
        elif not reason and sample.person in whole and sample.known[STILL].sum() >= 3:
            result.append(_completed(sample, whole[sample.person]))
        else:
            reason = reason or "lacks landmarks, and no other photo of this person has them all"
            left_out.append(f"{sample.path}: {reason}")
    return result, left_out


def _refusal(sample: Sample) -> str:
    """Why a machine's landmarks are not learned from; empty when they are."""
    if sample.machine and abs(sample.yaw_deg) > MOST_YAW_DEG:
        return f"turned by {sample.yaw_deg:.0f} degrees; learned from are machine-made landmarks up to {MOST_YAW_DEG:g}"
    if sample.machine and sample.outer_eye_px < LEAST_EYE_PX:
        return f"outer eye corners {sample.outer_eye_px:.0f} px apart; learned from are faces from {LEAST_EYE_PX:g} px"
    return ""


def _completed(sample: Sample, other: Sample) -> Sample:
    still = STILL[sample.known[STILL]]
    points, wanted = sample.points_px.copy(), ~sample.known
    over = similarity(other.points_px[still], sample.points_px[still])
    points[wanted] = transform(over, other.points_px[wanted])
    return dataclasses.replace(sample, points_px=points, guessed=wanted)

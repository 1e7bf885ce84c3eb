"""What each part of the thesis says and what is done here, in words."""

from __future__ import annotations

from typing import NamedTuple

TITLE = "The thesis, reproduced"

LEAD = (
    "Trajectory extraction for automatic face sketching (KTH Computer Science and Communication) goes from a photo"
    " of a face to lines that a robot arm draws. This page follows it chapter by chapter. Every picture is of free"
    " portraits and every number was computed when the page was made, by one command: limner evaluate thesis."
)


class Words(NamedTuple):
    """Of one section, figure or table: its title, what the thesis does or finds, what is done or found here."""

    title: str
    theirs: str
    ours: str


CHAPTERS = {
    "3.1": Words(
        "Edge extraction",
        "Gabor filters of eight orientations, thresholded, thinned and summed, after Tresset and Leymarie; or"
        " Canny's edges. No setting suits every photo, so the user chooses between the two.",
        "Both are styles (gabor, canny; gabor-pyramid has the four resolutions). The face is first brought to one"
        " size, so that one setting means the same in every photo. The default, portrait, grew out of them: it"
        " follows the features where the landmarks say they are.",
    ),
    "3.2": Words(
        "Detecting facial landmarks",
        "The flexible mixture of parts of Zhu and Ramanan, with the authors' program and their model for large faces.",
        "The same model, written anew: features, search by distance transforms, training by max margin, equal to the"
        " authors' program on their own pictures. A model trained on free photos is shipped; theirs can be used too.",
    ),
    "3.3": Words(
        "Improving landmark localization",
        "Brows move to the darkest point across them, the jaw to the strongest gradient, outliers to the spline"
        " through the others, eye corners to FAST corners; then a regularized spline, and principal components.",
        "Each is there by name (limner face --refine). The default is a learnt cascade instead, best, which the"
        " tables below show beside them.",
    ),
    "3.5": Words(
        "Edge extraction with landmark localization",
        "Components shorter than 20 pixels or far from every landmark go; boxes on landmarks and on an ellipse"
        " around the head, or the rectangle of the face, limit what stays; the rest is thinned.",
        "Each is a rule of trim.by, at the size to which the face was brought. The thesis's distance, 0.05 % of the"
        " area of the picture, is taken as a length, at the size of its test photos.",
    ),
    "4": Words(
        "Sketching the trajectories",
        "The left arm of Dumbo connects the points in turn, one pose goal after the other, orientation kept. Some"
        " poses could not be reached; each point took 1.5 seconds; strokes began with a trail of ink, lines were"
        " zigzags, the pen stuck or missed by a millimetre. A pen with a spring helped.",
        "The arm's limits are kept by construction: a place of the sheet where every point is within reach,"
        " closed-form inverse kinematics for the whole path at once, straight lines between points, the pen lifted"
        " and lowered vertically, and the fastest motion within the limits of the joints, checked before anything"
        " moves.",
    ),
}

FIGURES = {
    "3.1": Words("Gabor filters by orientation, and their sum", "Eight orientations; the sum is too rich to draw.", ""),
    "3.2": Words("Canny's edges by threshold and blur", "The automatic threshold gives far too many edges.", ""),
    "3.3": Words("Gabor filters at the original scale, before and after thinning", "", ""),
    "3.4": Words(
        "Trees of parts",
        "One tree for each view, after Zhu and Ramanan.",
        "The tree that Chow-Liu finds in our training photos. The shipped model has one view; a tilted face is"
        " turned level.",
    ),
    "3.5": Words("Landmarks as detected", "", "By the shipped model, before any correction."),
    "3.6": Words(
        "Jaw and brows: detected, searched along, corrected",
        "Across the spline the darkest point (brows) or the strongest gradient (jaw) is taken.",
        "Red as detected, yellow where was searched, green corrected.",
    ),
    "3.7": Words(
        "Corners near the eyes",
        "FAST on the sharpened picture; on the whole set the corners got worse.",
        "Here they neither gain nor lose on the whole set, and Harris's corners are worse (table 3.2): the strongest"
        " corner is often an eyelash.",
    ),
    "3.8": Words("Landmarks by principal components", "", "The shape model was learnt from other people."),
    "3.9": Words("The mean face and its first two components", "They capture turning and size.", "Likewise."),
    "3.10": Words("Curves by principal components, and by regularized splines", "", ""),
    "3.11": Words(
        "Splines through all landmarks",
        "Too simple to tell people apart.",
        "So it is here: the likeness score of splines is below 0.5, that of the default style about 0.9.",
    ),
    "3.12": Words("Boxes that limit the valid edges", "", ""),
    "3.13": Words("Edges, original and trimmed", "", ""),
    "3.14": Words("From the photo to what is drawn", "", "The last line is what limner adds to the thesis."),
    "4.2": Words(
        "The pose that drawing starts from",
        "Chosen by moving the arm by hand.",
        "The named pose, safe, of our model of Dumbo.",
    ),
    "4.3": Words(
        "The order of points within a component",
        "MATLAB's components list their points column by column; tracing the contour put them in order.",
        "The skeleton's graph is traced, straight on through crossings; each pixel is met once, where a contour"
        " runs along both sides of a line.",
    ),
    "4.4": Words(
        "All points, and only those far enough from each other",
        "About 2500 points took an hour, half of them half an hour.",
        "Time follows the length of the lines and their bends, not the number of points. Points are spent where a"
        " line bends.",
    ),
    "4.5": Words(
        "Line drawings and what the arm draws",
        "250 and 600 points, about 20 minutes each; zigzags, doubled lines and trails of ink are seen.",
        "Simulated with physics, the arm missing by up to a millimetre as the thesis's did: its way of moving, and"
        " ours. Red is ink that nobody planned, or that is missing.",
    ),
}

DIFFERENCES = (
    "Photos: the thesis's portraits are not published; free ones stand in. The IMM set is the same, but of its 120"
    " photos only those given were measured.",
    "Landmarks start better: our model's errors before correction are less than half of the thesis's, so that its"
    " corrections have less to mend, and some do harm.",
    "Units: the thesis gives pixels; per cent of the distance between the outer eye corners stand beside them.",
    "The arm here is simulated (MuJoCo). Masses, servo gains and the pen's spring are assumed, the thesis gives none.",
)

"""The number of a GRBL 1.1 error or alarm goes in; what it means and what to do comes out."""

from __future__ import annotations

ERRORS = {
    1: "a line does not begin with a letter",
    2: "a number is missing or malformed",
    3: "it does not know this $ command",
    4: "a value is negative that must not be",
    5: "homing is switched off ($22)",
    6: "the step pulse is too short",
    7: "its stored settings cannot be read and were reset",
    8: "this $ command is only possible while it is idle",
    9: "it is locked by an alarm; home it ($H) or unlock it ($X)",
    10: "soft limits need homing switched on ($22)",
    11: "a line is too long",
    12: "a setting asks for more steps per second than it can make",
    13: "the safety door is open",
    14: "a start-up line is too long to be stored",
    15: "a jog leads out of the machine's travel",
    16: "a jog command is malformed",
    17: "laser mode needs a variable spindle",
    20: "it does not know this command",
    21: "two commands of one group stand in a line",
    22: "no feed was set",
    23: "a number must be whole",
    24: "two commands in a line use the axes",
    25: "a word stands twice in a line",
    26: "axis words are missing",
    27: "a line number is out of range",
    28: "a word that the command needs is missing",
    29: "this coordinate system does not exist",
    30: "G53 goes with G0 and G1 only",
    31: "axis words stand where no command uses them",
    32: "an arc has no axis in its plane",
    33: "the target of a move is impossible",
    34: "the radius of an arc is impossible",
    35: "an arc has no centre",
    36: "a line has words that nothing uses",
    37: "the tool length axis is another",
    38: "the tool number is too large",
}

ALARMS = {
    1: "a limit switch was hit; its position is lost: free it, then home it ($H)",
    2: "a move would leave the machine's travel (soft limit); nothing moved",
    3: "it was reset while moving; its position is lost: home it ($H)",
    4: "the probe was not in its first state",
    5: "the probe touched nothing",
    6: "it was reset while homing",
    7: "the safety door was opened while homing",
    8: "homing did not clear the limit switch",
    9: "homing did not find the limit switch",
    10: "homing did not find the second limit switch",
}


def explained(answer: str) -> str:
    """What ``error:n`` or ``ALARM:n`` means, with the number."""
    kind, _, number = answer.partition(":")
    table = ERRORS if kind.lower() == "error" else ALARMS
    meaning = table.get(int(number), "unknown to limner") if number.strip().isdigit() else "unknown to limner"
    return f"{kind.lower()} {number.strip()}: {meaning}"

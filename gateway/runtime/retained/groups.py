"""Names that may be kept over a restart: GROUP.rest (AX-425).  Commands, releases, start bits and RC inputs belong to no group."""

GROUPS = {
    "flags": "markers and flags of the control, M0 .. as bytes",
    "counter": "counters of the PIC: what is left to count",
    "order": "named values of telegrams and routes that hold data",
    "belt": "offsets of belts",
}


def group_of(name: str) -> str:
    """The group a name belongs to.  ValueError: the value of this name must not outlive a run."""
    group = name.partition(".")[0]
    if group not in GROUPS:
        raise ValueError(f"{name}: is not kept over a restart; groups that are: {', '.join(GROUPS)}")
    return group

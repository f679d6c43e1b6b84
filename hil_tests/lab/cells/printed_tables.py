"""The example of five endless axes, as the manual prints it: rho 3 Releases part 1, TO04 section 11 (L5626-5633)."""

PROGRAM = (  # deg of the master and of four slaves
    (20, 0, 0, 360, 0),
    (90, 120, 0, 0, 0),
    (105, 150, 0, 0, 0),
    (190, 300, 160, 0, 180),
    (200, 320, 180, 160, 240),
    (220, 360, 260, 200, 360),
    (280, 0, 360, 260, 0),
    (360, 0, 0, 320, 0),
)

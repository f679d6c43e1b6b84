"""Machine configuration code P2 at the interface.  Source: rho3 3.3 (L3929-3958)."""

from gateway.pure.controllers.pic_image import PicImage

MA_TYP_0 = 124  # RC outputs 124..127


def show_machine(image: PicImage, p2: int) -> None:
    """P2 (0..15) as four bits, lowest at MA_TYP_0; ValueError otherwise."""
    if not 0 <= p2 <= 15:
        raise ValueError(f"P2 = {p2}: the machine configuration is 0..15")
    for bit in range(4):
        image.put(MA_TYP_0 + bit, bool(p2 >> bit & 1))

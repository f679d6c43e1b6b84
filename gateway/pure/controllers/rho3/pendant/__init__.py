"""The teach pendants of the rho 3: PHG 3 (4 x 20 characters) and PHG 2000 (256 x 128 pixels), variables by number, modes, INFO texts."""

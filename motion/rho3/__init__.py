"""Coordinates and limits as the rho 3 means them."""

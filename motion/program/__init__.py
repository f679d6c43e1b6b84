"""Programs of the motion core: neutral blocks, their text form, and the rules by which three old controllers fill them."""

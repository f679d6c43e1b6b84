"""Outputs that follow the path: IO logic, PPO, and the outputs of neutral blocks."""

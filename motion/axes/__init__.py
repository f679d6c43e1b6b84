"""What single axes of a kinematic may and may not do: drive-on logic, disabled axes, set-point outputs that several axes share."""

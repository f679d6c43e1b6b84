"""What an editor asks of a program of an old control: faults, outline, hover, definition; `axisgate lsp` serves it."""

"""What an editor asks of a program of an old controller: faults, outline, hover, definition; `axisgate lsp` serves it."""

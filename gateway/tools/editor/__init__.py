"""Editor requests about a program of an old controller: faults, outline, hover, definition; `axisgate lsp` serves them."""

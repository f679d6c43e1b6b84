"""VAL 3, the language of Staubli controllers: files, checker, translation, tasks and built-in instructions.  Source: VAL 3 reference, version 8."""

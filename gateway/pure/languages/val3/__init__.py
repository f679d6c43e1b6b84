"""VAL 3, the language of Staubli controllers: files, checker, translation, tasks, instructions.  Source: VAL 3 reference 8."""

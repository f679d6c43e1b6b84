"""ROBOTstar V programs: the language, its checker, its interpreter in virtual time."""

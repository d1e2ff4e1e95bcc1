"""The paper: its study, its figures, its claims, decided by numbers, and the tables of them that the release holds."""

"""What a user sees of a run: tables, figures, progress."""

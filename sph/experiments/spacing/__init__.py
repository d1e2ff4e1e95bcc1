"""What a second spacing changes in the runs of a study."""

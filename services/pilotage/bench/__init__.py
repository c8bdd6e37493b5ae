"""How long the localizer's work takes, beside plain numpy doing the same in the same run."""

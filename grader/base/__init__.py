"""What every room stands on: errors, text of strangers, files written whole, instants."""

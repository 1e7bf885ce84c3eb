"""The outside: files and machines that a drawing goes to."""

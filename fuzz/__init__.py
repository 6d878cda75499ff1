"""Every reader of files against inputs that nobody meant: `make fuzz`, see `docs/files.md`."""

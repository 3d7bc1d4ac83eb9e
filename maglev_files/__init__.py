"""Files that appear when they are complete, and temporary folders that go: for all packages."""

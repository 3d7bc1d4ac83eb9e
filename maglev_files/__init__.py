"""Files that appear when they are complete, temporary folders that go, programs that end: for all packages."""

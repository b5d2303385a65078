"""Speed of this package beside other ways to run the same job; see README.md."""

"""Files of every format to records, and records to files. Nothing in a file is ever executed."""

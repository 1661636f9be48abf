//! From a thrust log to a soft touchdown on a moving deck: the toolkit and its command line.

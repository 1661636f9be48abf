//! The report of `touchdown reproduce`.

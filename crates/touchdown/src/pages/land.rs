//! The report of `touchdown land`.

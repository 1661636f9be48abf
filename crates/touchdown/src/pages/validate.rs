//! The report of `touchdown validate`.

//! The report of `touchdown inspect`.

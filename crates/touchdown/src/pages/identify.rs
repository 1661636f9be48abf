//! The report of `touchdown identify`.

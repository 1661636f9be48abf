//! The model card: schema, checks, card to flight model.

//! What to write into a map.

/// What to write into the map: `channel` as a function of its column, which stands between `before` and `after`.
pub(crate) fn map_line(channel: &str, before: &str, after: &str) -> String {
    format!(
        "write into the map: {channel} = '{before}\"{channel}\"{after}' (with the log's own name of the column)"
    )
}

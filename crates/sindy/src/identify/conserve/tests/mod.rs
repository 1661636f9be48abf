mod fields;
mod fits;

mod fields;
mod fits;
mod relations;

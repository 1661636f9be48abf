//! The tests in one program: what they share is compiled once.

mod afar;
mod batch;
mod cascade;
mod closed_forms;
mod commanded;
mod contact;
mod deck;
mod fast_camera;
mod independence;
mod landing;
mod late;
mod plant;
mod policy;
mod rig;
mod rigid;
mod rotors;
mod space;
mod space_decks;
mod space_record;
mod space_settings;
mod under_way;
mod unseen;
mod weather;
mod wind;

//! Modes: poles, shapes, the modal model that test and theory share, and measures on shapes alone.

mod complexity;
mod mac;
mod model;
mod pole;
mod quality;
mod selection;
mod shape;
mod unmeasured;

pub use complexity::{mean_phase, mean_phase_deviation, modal_phase_collinearity};
pub use mac::{mac, mac_matrix, modal_scale_factor};
pub use model::{InputFile, ModalModel, Mode, Scaling};
pub use pole::Pole;
pub use quality::{Grade, Quality};
pub use selection::{PoleSelection, SelectedPole};
pub use shape::ModeShape;

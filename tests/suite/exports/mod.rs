//! Files as measurement systems export them: each kind in the form in which a public report of a
//! reader describes it, with siblings of it, made here.

mod axes;
mod byte_order;
mod check_sums;
mod complex_text;
mod containers;
mod control;
mod damage_search;
mod excitation;
mod hdf5_links;
mod hits;
mod inspected;
mod joined;
mod mass_line;
mod matlab4;
mod mode_builder;
mod mode_poles;
mod mode_rotations;
mod mode_zeros;
mod names;
mod not_a_number;
mod other_quantities;
mod signalcalc_mat;
mod structured_arrays;
mod text_coding;
mod units;
mod universal_file;

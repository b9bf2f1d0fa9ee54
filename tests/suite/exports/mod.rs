//! Files as measurement systems export them: each kind in the form in which a public report of a
//! reader describes it, with siblings of it, made here.

mod axes;
mod byte_order;
mod complex_text;
mod control;
mod excitation;
mod hits;
mod names;
mod other_quantities;
mod units;
mod damage_search;
mod inspected;
mod joined;
mod not_a_number;
mod text_coding;
mod check_sums;
mod containers;
mod control;
mod hdf5_links;
mod matlab4;
mod structured_arrays;
mod universal_file;

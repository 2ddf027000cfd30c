//! Surfaces in formats of other programs: CSV, JSON, NPZ for NumPy, and MAT for MATLAB and Octave.

pub mod columns;

pub mod text;

pub mod arrays;

pub mod npz;

pub mod mat;

pub mod format;

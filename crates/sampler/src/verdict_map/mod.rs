//! Maps of verdicts over two inputs. They know verdicts and a plane, no physics.

pub mod boundary_curve;

pub mod map;

//! Forged files of every format: sound ones with bytes changed.

use std::env;
use std::fs;

use super::tests::data;
use super::{align, names, read};
use crate::files::forging::{Numbers, assert_bounded_of};

/// How many forged files each format gets; more with this variable, for runs by hand.
const MANY: &str = "STICKSLIP_FORGED_MATRICES";

/// Asserts that forged files, made from sound ones of a format, are read or refused.
#[track_caller]
fn assert_refused(test: &str, ending: &str, files: &[&str]) {
    let sound: Vec<Vec<u8>> = files.iter().map(|file| fs::read(data(file)).unwrap()).collect();
    let count = env::var(MANY).map_or(2000, |count| count.parse().unwrap());
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join(format!("forged{ending}"));
    // Many changes leave a sound text: other digits.
    let refused = assert_bounded_of(&format!("matrix_files::forged::{test}"), &sound, count, forged, |bytes| {
        fs::write(&path, bytes).unwrap();
        let names = names(&path).map_err(|error| error.to_string())?;
        let all: Vec<Option<&str>> =
            if names.is_empty() { vec![None] } else { names.iter().take(8).map(|name| Some(&**name)).collect() };
        let matrices: Result<Vec<_>, _> = all.iter().map(|name| read(&path, *name)).collect();
        let matrices = matrices.map_err(|error| error.to_string())?;
        let same = vec![matrices[0].clone(), matrices[0].clone()];
        align(same).map(|_| ()).map_err(|error| error.to_string())?;
        // What was read may be anything, but not of different sizes only.
        let _ = align(matrices);
        Ok(())
    });
    assert!(refused.is_none_or(|refused| refused > count / 4), "only {refused:?} of {count} were refused");
}

/// A file with a few bytes changed, a piece repeated or left out, or its end cut off.
fn forged(sound: &[u8], numbers: &mut Numbers) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    for _ in 0..=numbers.below(4) {
        let at = numbers.below(bytes.len());
        let length = (1 + numbers.below(24)).min(bytes.len() - at);
        match numbers.below(12) {
            0 => bytes[at] = numbers.below(256) as u8,
            1 => bytes[at] ^= 1 << numbers.below(8),
            2 => bytes[at] = [0, 0x7f, 0x80, 0xff][numbers.below(4)],
            3 => bytes[at..at + length.min(8)].fill(0xff),
            4 => bytes[at] = b"0123456789+-.eED,* \n%$"[numbers.below(22)],
            5 => {
                let large: [&[u8]; 6] = [b"99999999", b"-1", b"1e999", b"nan", b"4294967296", b"18446744073709551616"];
                let large = large[numbers.below(6)];
                let end = (at + large.len()).min(bytes.len());
                bytes[at..end].copy_from_slice(&large[..end - at]);
            }
            6 => drop(bytes.drain(at..at + length)),
            7 => {
                let piece = bytes[at..at + length].to_vec();
                let to = numbers.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            8 => {
                let from = numbers.below(sound.len() - length.min(sound.len()) + 1);
                let length = length.min(sound.len());
                bytes[at..at + length].copy_from_slice(&sound[from..from + length]);
            }
            9 => bytes[at] = bytes[at].wrapping_add(1),
            10 => bytes[at] = bytes[at].wrapping_sub(1),
            // Most cut files are like each other.
            _ if numbers.below(4) == 0 => bytes.truncate(at.max(1)),
            _ => bytes.insert(at, b" \n,0*"[numbers.below(5)]),
        }
        if bytes.is_empty() {
            bytes.push(0);
        }
    }
    bytes
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn forged_mat_files() {
    let files = ["scipy-plain.mat", "scipy-compressed.mat", "octave-v6.mat", "octave-v7.mat", "hand-big-endian.mat"];
    assert_refused("forged_mat_files", ".mat", &files);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn forged_matrix_market_files() {
    let files = ["scipy-K.mtx", "scipy-G.mtx", "scipy-KF.mtx", "scipy-K-array.mtx", "scipy-G-array.mtx"];
    assert_refused("forged_matrix_market_files", ".mtx", &files);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn forged_archives_of_numpy() {
    let files = [
        "numpy-plain.npz",
        "numpy-compressed.npz",
        "scipy-K-csr.npz",
        "scipy-M-csc.npz",
        "scipy-KF-coo.npz",
        "scipy-C-dia.npz",
        "scipy-G-bsr.npz",
    ];
    assert_refused("forged_archives_of_numpy", ".npz", &files);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn forged_arrays_of_numpy() {
    assert_refused("forged_arrays_of_numpy", ".npy", &["numpy-K.npy", "numpy-M-big-endian.npy"]);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn forged_files_of_abaqus() {
    let files = ["abaqus_STIF2.mtx", "abaqus_STIF3.mtx", "abaqus-coordinate_STIF4.mtx", "abaqus-coordinate_STIF5.mtx"];
    assert_refused("forged_files_of_abaqus", ".mtx", &files);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn forged_substructures() {
    assert_refused("forged_substructures", ".mtx", &["abaqus-substructure.mtx", "ccx-substructure.mtx"]);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn forged_cards_of_nastran() {
    assert_refused("forged_cards_of_nastran", ".pch", &["nastran-small.pch", "nastran-wide.pch", "nastran-double.pch"]);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn forged_files_of_calculix() {
    assert_refused("forged_files_of_calculix", ".sti", &["ccx-brick.sti", "ccx-brick.mas"]);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn forged_harwell_boeing_files() {
    let files = ["scipy-K.rua", "scipy-KF.rua", "ansys-K.matrix", "ansys-KF.matrix"];
    assert_refused("forged_harwell_boeing_files", ".rsa", &files);
}

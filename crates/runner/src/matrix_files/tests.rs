//! Files of other programs, and what is said of files that are wrong. `tests/data/matrices/make.py` says who wrote which.

use std::collections::HashMap;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use flate2::write::{DeflateEncoder, ZlibEncoder};
use flate2::{Compression, Crc};

use super::{ReadMatrix, Stored, align, names, read};

/// Degrees of freedom of the model in `model.csv`.
const SIZE: usize = 8;
const NODES: [i64; 4] = [11, 12, 23, 24];

pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/matrices").join(name)
}

type Dense = Vec<Vec<f64>>;

fn dense(read: &ReadMatrix) -> Dense {
    let matrix = &read.matrix;
    let mut rows = vec![vec![0.0; matrix.ncols()]; matrix.nrows()];
    for entry in matrix.triplet_iter() {
        assert!(*entry.val != 0.0, "zeros are left out");
        rows[entry.row][entry.col] = *entry.val;
    }
    rows
}

fn model() -> HashMap<String, Dense> {
    let mut matrices = HashMap::new();
    for line in fs::read_to_string(data("model.csv")).unwrap().lines().skip(1) {
        let [name, row, column, value] = line.split(',').collect::<Vec<_>>()[..] else { panic!("{line}") };
        let matrix = matrices.entry(name.to_owned()).or_insert_with(|| vec![vec![0.0; SIZE]; SIZE]);
        matrix[row.parse::<usize>().unwrap()][column.parse::<usize>().unwrap()] = value.parse().unwrap();
    }
    matrices
}

fn sound(file: &str, name: Option<&str>) -> ReadMatrix {
    read(&data(file), name).unwrap_or_else(|error| panic!("{error}"))
}

/// What is said of a file with this content and ending.
fn refusal(ending: &str, content: &[u8], name: Option<&str>) -> String {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join(format!("brake{ending}"));
    fs::write(&path, content).unwrap();
    let message = read(&path, name).unwrap_err().to_string();
    message.replace(&format!("{}/", place.path().display()), "")
}

#[test]
fn files_of_eight_programs_read_alike() {
    use Stored::{General, SkewTriangle, SymmetricTriangle};
    let model = model();
    for (file, names, matrix, stored) in [
        ("scipy-plain.mat", &["M", "C", "G", "K", "KF"][..], "", General),
        ("scipy-compressed.mat", &["M", "C", "G", "K", "KF"], "", General),
        ("octave-v6.mat", &["M", "C", "G", "K", "KF"], "", General),
        ("octave-v7.mat", &["M", "C", "G", "K", "KF"], "", General),
        ("hand-big-endian.mat", &["K", "KF"], "", General),
        ("numpy-plain.npz", &["M", "C", "G", "K", "KF"], "", General),
        ("numpy-compressed.npz", &["M", "C", "G", "K", "KF"], "", General),
        ("scipy-M.mtx", &[], "M", SymmetricTriangle),
        ("scipy-C.mtx", &[], "C", SymmetricTriangle),
        ("scipy-G.mtx", &[], "G", SkewTriangle),
        ("scipy-K.mtx", &[], "K", SymmetricTriangle),
        ("scipy-KF.mtx", &[], "KF", General),
        ("scipy-integer.mtx", &[], "KF", General),
        ("scipy-K-array.mtx", &[], "K", SymmetricTriangle),
        ("scipy-G-array.mtx", &[], "G", SkewTriangle),
        ("scipy-KF-array.mtx", &[], "KF", General),
        ("scipy-K-csr.npz", &[], "K", General),
        ("scipy-M-csc.npz", &[], "M", General),
        ("scipy-KF-coo.npz", &[], "KF", General),
        ("scipy-C-dia.npz", &[], "C", General),
        ("scipy-G-bsr.npz", &[], "G", General),
        ("numpy-K.npy", &[], "K", General),
        ("numpy-M-big-endian.npy", &[], "M", General),
        ("scipy-K.rua", &[], "K", General),
        ("scipy-M.rua", &[], "M", General),
        ("scipy-KF.rua", &[], "KF", General),
        ("ansys-K.matrix", &[], "K", SymmetricTriangle),
        ("ansys-M.matrix", &[], "M", SymmetricTriangle),
        ("ansys-KF.matrix", &[], "KF", General),
        ("abaqus-coordinate_STIF4.mtx", &[], "K", SymmetricTriangle),
        ("abaqus-coordinate_MASS4.mtx", &[], "M", SymmetricTriangle),
        ("abaqus_DMPV2.mtx", &[], "C", SymmetricTriangle),
    ] {
        if names.is_empty() {
            let read = sound(file, None);
            assert!(dense(&read) == model[matrix] && read.stored == stored, "{file}: {read:?}");
        }
        for name in names {
            let read = sound(file, Some(name));
            assert!(dense(&read) == model[*name] && read.stored == stored, "{file}, {name}: {read:?}");
        }
    }
    for (name, matrix) in [("STIFFNESS", "K"), ("MASS", "M"), ("VISCOUS DAMPING", "C")] {
        let read = sound("abaqus-substructure.mtx", Some(name));
        assert_eq!((dense(&read), read.stored), (model[matrix].clone(), SymmetricTriangle), "{name}");
        assert_eq!(read.degrees_of_freedom, Some(places()));
    }
}

/// The numbers of entries are those that its authors print (Graebner et al., ZAMM 96 (2016) 1388). Five of the matrices have
/// a stored zero among them, the last one on the diagonal, which reading leaves out.
#[test]
fn the_brake_of_tu_berlin_has_the_entries_that_its_authors_print() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../jobs/tu-brake/tu-brake.mat");
    for (name, entries, zeros) in [
        ("M", 93_207, 0),
        ("D1", 5683, 1),
        ("DG", 66_643, 1),
        ("DR", 5683, 1),
        ("D4", 23_885, 1),
        ("K1", 280_845, 0),
        ("KR", 21_646, 1),
        ("KGEO", 280_871, 0),
    ] {
        let matrix = read(&path, Some(name)).unwrap().matrix;
        assert_eq!((matrix.nrows(), matrix.compute_nnz() + zeros), (4669, entries), "{name}");
    }
}

/// The degrees of freedom of the model.
fn places() -> Vec<(i64, u32)> {
    NODES.iter().flat_map(|node| [(*node, 1), (*node, 3)]).collect()
}

#[test]
fn matrices_over_some_nodes_are_brought_to_all_of_them() {
    let model = model();
    for file in ["nastran-small.pch", "nastran-wide.pch", "nastran-double.pch"] {
        assert_eq!(names(&data(file)).unwrap(), ["MAAX", "BAAX", "GAAX", "KAAX", "K2PP"], "{file}");
        let matrices = ["MAAX", "BAAX", "GAAX", "KAAX", "K2PP"].map(|name| sound(file, Some(name)));
        assert_eq!(matrices[4].matrix.nrows(), 4, "the friction of two nodes");
        assert_eq!(matrices[3].stored, Stored::SymmetricTriangle);
        for (read, name) in align(matrices.to_vec()).unwrap().iter().zip(["M", "C", "G", "K", "KF"]) {
            assert!(dense(read) == model[name], "{file}, {name}: {:?}", dense(read));
            assert_eq!(read.degrees_of_freedom, Some(places()));
        }
    }
}

#[test]
fn degrees_of_freedom_that_abaqus_holds_are_taken_out_everywhere() {
    let model = model();
    let files =
        [("abaqus_MASS2.mtx", "M"), ("abaqus_DMPV2.mtx", "C"), ("abaqus_STIF2.mtx", "K"), ("abaqus_STIF3.mtx", "KF")];
    let matrices: Vec<ReadMatrix> = files.iter().map(|(file, _)| sound(file, None)).collect();
    let rows: Vec<usize> = matrices.iter().map(|read| read.matrix.nrows()).collect();
    assert_eq!(rows, [9, 8, 9, 4]);
    assert_eq!((&matrices[2].constrained, matrices[2].stored), (&vec![3], Stored::SymmetricTriangle));
    assert!(matrices[2].notes[1].contains("taken out of all matrices: 1"), "{:?}", matrices[2].notes);
    assert_eq!(matrices[3].stored, Stored::General);
    for (read, (file, name)) in align(matrices).unwrap().iter().zip(files) {
        assert!(dense(read) == model[name], "{file}: {:?}", dense(read));
        assert_eq!((read.degrees_of_freedom.clone(), read.constrained.len()), (Some(places()), 0));
    }
}

#[test]
fn matrices_without_nodes_fit_by_their_number_of_rows() {
    let model = model();
    // COORDINATE does not say how many rows there are; the friction has entries up to row 5.
    let friction = sound("abaqus-coordinate_STIF5.mtx", None);
    assert_eq!((friction.matrix.nrows(), friction.has_size, friction.stored), (6, false, Stored::General));
    for stiffness in [
        sound("abaqus-coordinate_STIF4.mtx", None),
        sound("scipy-K.mtx", None),
        sound("nastran-wide.pch", Some("KAAX")),
    ] {
        let both = align(vec![friction.clone(), stiffness]).unwrap();
        assert_eq!([dense(&both[0]), dense(&both[1])], [model["KF"].clone(), model["K"].clone()]);
    }
    // With held degrees of freedom in the map, and without them in a file that does not know them.
    let both = align(vec![sound("abaqus_STIF2.mtx", None), sound("scipy-M.mtx", None)]).unwrap();
    assert_eq!([dense(&both[0]), dense(&both[1])], [model["K"].clone(), model["M"].clone()]);
    let error = align(vec![sound("scipy-K.mtx", None), sound("ccx-brick.sti", None)]).unwrap_err();
    assert_eq!(
        (error.matrix, error.to_string()),
        (0, "the matrix has 8 rows, but the other matrices of the model have 12; matrices of one model have the same degrees of freedom".to_owned())
    );
}

#[test]
fn calculix_writes_the_same_brick_in_two_ways() {
    let (stiffness, mass) = (sound("ccx-brick.sti", None), sound("ccx-brick.mas", None));
    assert_eq!((stiffness.stored, stiffness.has_size), (Stored::SymmetricTriangle, true));
    assert!(stiffness.notes.iter().any(|note| note.contains("friction, which is not symmetric, is lost")));
    let all: Vec<(i64, u32)> = (25..=28).flat_map(|node| (1..=3).map(move |direction| (node, direction))).collect();
    assert_eq!(stiffness.degrees_of_freedom.as_ref(), Some(&all));
    // A brick of 2 by 1 by 1 mm that moves linearly with the height: a third of its mass in each of three directions.
    let total: f64 = dense(&mass).iter().flatten().sum();
    assert!((total / (7.1e-9 * 2.0) - 1.0).abs() < 1e-9, "{total}");
    let substructure = sound("ccx-substructure.mtx", Some("STIFFNESS"));
    assert_eq!(names(&data("ccx-substructure.mtx")).unwrap(), ["STIFFNESS"]);
    assert_eq!(substructure.degrees_of_freedom.as_deref(), Some(&all[..9]));
    let (one, other) = (dense(&stiffness), dense(&substructure));
    for row in 0..9 {
        for column in 0..9 {
            // They have 14 and 13 digits.
            assert!((one[row][column] - other[row][column]).abs() < 1e-6, "{row}, {column}");
        }
    }
}

#[test]
fn names_are_those_of_what_can_be_read() {
    for (file, expected) in [
        ("scipy-plain.mat", &["M", "C", "G", "K", "KF", "flags", "bits", "counts", "singles", "list"][..]),
        ("octave-v7.mat", &["M", "C", "G", "K", "KF"]),
        ("numpy-compressed.npz", &["M", "C", "G", "K", "KF"]),
        ("scipy-K-csr.npz", &[]),
        ("scipy-K.mtx", &[]),
        ("abaqus-substructure.mtx", &["STIFFNESS", "MASS", "VISCOUS DAMPING"]),
    ] {
        assert_eq!(names(&data(file)).unwrap(), expected, "{file}");
    }
    let flags = sound("scipy-compressed.mat", Some("flags"));
    assert_eq!(dense(&flags)[2][3], 1.0);
    assert_eq!(dense(&sound("scipy-compressed.mat", Some("counts")))[2], [6.0, 7.0, 8.0]);
    assert_eq!(dense(&sound("scipy-compressed.mat", Some("singles"))), [[0.5, 2.0], [0.0, -1.5]]);
    let bits = sound("scipy-plain.mat", Some("bits"));
    assert_eq!(bits.matrix.compute_nnz(), sound("scipy-M.mtx", None).matrix.compute_nnz());
}

#[test]
fn what_is_wrong_with_a_name_is_said_with_the_names_there_are() {
    for (file, name, words) in [
        (
            "octave-v7.mat",
            Some("K7"),
            &["octave-v7.mat: there is no matrix `K7` (there are `M`, `C`, `G`, `K`, `KF`)"][..],
        ),
        ("octave-v7.mat", Some("kf"), &["do you mean `KF`?"]),
        ("octave-v7.mat", None, &["the file has several matrices; say which with `matrix = \"M\"`"]),
        ("octave-v7.mat", Some("inside"), &["matrix `inside`: it is a struct; save the matrices in it as variables"]),
        ("octave-v7.mat", Some("parts"), &["matrix `parts`: it is a cell array"]),
        ("octave-v7.mat", Some("note"), &["matrix `note`: it is a text"]),
        ("scipy-plain.mat", Some("wave"), &["matrix `wave`: it is complex; save real matrices"]),
        ("scipy-plain.mat", Some("list"), &["matrix `list`: the matrix has 3 rows and 1 columns"]),
        ("numpy-compressed.npz", Some("wave"), &["matrix `wave`: it has complex numbers"]),
        ("scipy-K.mtx", Some("K"), &["the file has one matrix without a name", "leave out `matrix`"]),
        ("nastran-wide.pch", Some("KAA"), &["there are `MAAX`, `BAAX`, `GAAX`, `KAAX`, `K2PP`"]),
        ("ccx-substructure.mtx", Some("MASS"), &["there is no matrix `MASS` (there are `STIFFNESS`)"]),
        ("scipy-v4.mat", None, &["version 4", "'-v7')"]),
        ("octave-text.mat", None, &["Octave's own format", "save -v7"]),
        ("absent.mat", None, &["cannot open the file"]),
        (".", None, &["this is no file"]),
    ] {
        let message = read(&data(file), name).unwrap_err().to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{file}: {message}");
    }
}

#[test]
fn formats_that_are_not_read_are_named_with_the_remedy() {
    let hdf5 =
        [b"MATLAB 7.3 MAT-file, Platform: GLNXA64".to_vec(), vec![b' '; 474], b"\x89HDF\r\n\x1a\n".to_vec()].concat();
    for (ending, content, words) in [
        (".mat", &hdf5[..], &["version 7.3 (HDF5)", "save('brake.mat', 'M', 'K', '-v7')"][..]),
        (".h5", b"\x89HDF\r\n\x1a\nx", &["HDF5"]),
        (".mat", b"hello", &["no MAT file"]),
        (".full", b"\0\x01", &["binary file of Ansys", "HBMAT,"]),
        (".sub", b"\0\x01", &["HBMAT,"]),
        (".sim", b"\0\x01", &["*MATRIX GENERATE, STIFFNESS", "FORMAT=MATRIX INPUT"]),
        (".odb", b"\0\x01", &["*MATRIX OUTPUT"]),
        (".op2", b"\0\x01", &["PARAM,EXTOUT,DMIGPCH"]),
        (".bin", b"ab\0\x01", &["the file is binary", "Matrix Market"]),
        (".txt", b"hello\n", &["no format of matrices that is read", "Harwell-Boeing"]),
        ("", b"", &["the file is empty"]),
    ] {
        let message = refusal(ending, content, None);
        assert!(words.iter().all(|word| message.contains(word)), "{ending}: {message}");
    }
}

#[test]
fn texts_that_are_wrong_are_refused_with_line_value_and_limit() {
    let market = |rest: &str| format!("%%MatrixMarket matrix {rest}");
    let substructure = |rest: &str| format!("*USER ELEMENT,NODES=1,LINEAR\n** ELEMENT NODES\n** 7\n1,2\n{rest}");
    let boeing = |rest: &str| format!("title\n 3 1 1 1 0\n{rest}");
    let dmig = |rest: &str| format!("DMIG,K,0,6,2,0\n{rest}");
    for (ending, text, words) in [
        (
            ".mtx",
            market("coordinate real general\n2 2 1\n3 1 5.0\n"),
            "brake.mtx:3: the row is 3, but the matrix has 2 rows and columns",
        ),
        (
            ".mtx",
            market("coordinate real general\n2 2 1\n1.5 1 5.0\n"),
            ":3: the row is `1.5`, which is no whole number from 1 to 2",
        ),
        (".mtx", market("coordinate real general\n2 2 1\n0 1 5.0\n"), ":3: the row is 0"),
        (".mtx", market("coordinate real general\n2 2 1\n1 1 NaN\n"), ":3: `NaN` is no finite number"),
        (".mtx", market("coordinate real general\n2 2 1\n1 1 1e999\n"), ":3: `1e999` is no finite number"),
        (".mtx", market("coordinate real general\n2 2 1\n1 1 inf\n"), ":3: `inf` is no finite number"),
        (".mtx", market("coordinate real general\n2 2 2\n1 1 1.0\n"), "ends after 1 of 2 entries"),
        (".mtx", market("coordinate real general\n2 2 1\n1 1 1.0\n2 2 1.0\n"), ":4: there are more than the 1 entries"),
        (
            ".mtx",
            market("coordinate real general\n2 2 4000000000\n"),
            ":2: there should be 4000000000 entries, for which the file",
        ),
        (
            ".mtx",
            market("coordinate real general\n4000000000 4000000000 1\n1 1 1\n"),
            "the matrix has 4000000000 rows; the limit is 16777216",
        ),
        (".mtx", market("coordinate real general\n2 3 1\n1 1 1\n"), "2 rows and 3 columns"),
        (
            ".mtx",
            market("coordinate pattern general\n2 2 1\n1 1\n"),
            ":1: the file holds places without values (pattern)",
        ),
        (".mtx", market("coordinate complex general\n2 2 1\n1 1 1 1\n"), ":1: the matrix is complex"),
        (".mtx", market("coordinate complex hermitian\n2 2 1\n1 1 1 1\n"), ":1: the matrix is complex"),
        (
            ".mtx",
            market("coordinate real symmetric\n2 2 3\n1 1 1\n1 2 3\n2 1 3\n"),
            "row 2 and column 1 is given twice, perhaps once in each triangle",
        ),
        (
            ".mtx",
            market("coordinate real skew-symmetric\n2 2 1\n1 1 1\n"),
            "skew-symmetric, but has an entry on the diagonal, in row 1",
        ),
        (".mtx", market("coordinate real general\n2 2 2\n1 1 1e308\n1 1 1e308\n"), "row 1 and column 1 is inf"),
        (".mtx", "1,1,1,1,5.0\n2,1,2,1\n".to_owned(), ":2: `2,1,2,1` is not `node, direction, node, direction, value`"),
        (
            ".mtx",
            "1,1,1,1,5.0\n-3,1,1,1,2.0\n-3,1,-4,1,2.0\n".to_owned(),
            "2 entries are of 2 internal nodes (numbers below 1): Lagrange multipliers",
        ),
        (".mtx", "1,1,1,1,5.0\n2,x,2,1,1\n".to_owned(), ":2: `x` is no direction of a degree of freedom"),
        (".mtx", "1 1 5.0\n1 0 5.0\n".to_owned(), ":2: the column is 0, but it should be from 1 to 16777216"),
        (".mtx", "1 1 5.0\n1 999999999 5.0\n".to_owned(), ":2: the column is 999999999"),
        (
            ".mtx",
            substructure("*MATRIX,TYPE=STIFFNESS\n1.,\n2., 3.,\n4.,\n"),
            "matrix `STIFFNESS`: the file ends within row 3, after 1 of 3 values",
        ),
        (
            ".mtx",
            substructure("*MATRIX,TYPE=STIFFNESS\n1.,\n*MATRIX,TYPE=STIFFNESS\n1.,\n"),
            "there more than once: these may be matrices of elements",
        ),
        (".mtx", substructure("*MATRIX\n1.,\n"), ":5: the matrix has no type"),
        (".pch", dmig("DMIG,K,1,1,,1,1,abc\n"), ":2: `abc` is no finite number"),
        (
            ".pch",
            dmig("DMIG,K,1,1,,1,2,1.0\nDMIG,K,1,2,,1,1,1.0\n"),
            "matrix `K`: one triangle of the matrix should be given, but the entry of row 2 and column 1",
        ),
        (".pch", dmig("DMIG,K,0,6,2,0\n"), ":2: matrix `K` starts a second time"),
        (".pch", "DMIG,K,0,9,2,0\n".to_owned(), "IFO is 9"),
        (
            ".pch",
            dmig(",1,1,2.0\nDMIG,K,2,1,,2,1,2.0\n"),
            ":2: there is an entry after the header; the card of its column is missing before it",
        ),
        (
            ".pch",
            dmig("DMIG,K,1,1,,1,1,1.0\n,2,1,3.0\n,2,1,4.0\n"),
            ":4: the row of grid point 2 and component 1 is there twice in one card",
        ),
        (
            ".pch",
            dmig("DMIG,K,1,1,,1,1,1.0\nDMIG,L,2,1,,2,1,4.0\n"),
            ":3: the column is of matrix `L`, which has no header",
        ),
        (".pch", dmig("DMIG,K,1,1,,1,1,1.0"), ":2: the last line has no end"),
        (".mtx", "1,1,1,1,5.0\n2,1,2,1,1.25".to_owned(), ":2: the last line has no end"),
        (".mtx", "1 1 5.0\n2 2 1.25".to_owned(), ":2: the last line has no end"),
        (".sti", "1 1 5.0\n2 2 1.25".to_owned(), ":2: the last line has no end"),
        (".mtx", substructure("*MATRIX,TYPE=STIFFNESS\n1.,\n2., 3."), ":7: the last line has no end"),
        (
            ".mtx",
            "2 2 1\n1 2 -1.5\n".to_owned(),
            ":1: this may be an entry, or a line of Matrix Market for 2 rows, 2 columns and the 1 entries that follow",
        ),
        (".pch", "DMIG,K,0,6,4,0\n".to_owned(), "TIN is 3 or 4"),
        (".pch", dmig(""), "matrix `K`: the matrix has no rows"),
        (".sti", "1 1 1.0\n1 2 1.0\n2 1 1.0\n".to_owned(), "CalculiX writes one triangle"),
        (
            ".rsa",
            boeing("CSA 1 1 1 0\n(1I8) (1I8) (1E20.12)\n"),
            ":3: the matrix is of the type `CSA`, complex; RSA, RUA and RZA are read",
        ),
        (".rsa", boeing("RSE 1 1 1 0\n(1I8) (1I8) (1E20.12)\n"), "`RSE`, which is not assembled"),
        (".rsa", boeing("RSA 1 1 1 0\n(1I8) (1X) (1E20.12)\n"), ":4: the format `(1X)` is none like (10I8)"),
        (
            ".rsa",
            boeing("RSA 1 1 1 0\n(1I8) (1I8) (1E20.12)\n1\n2\n1\n"),
            ":8: the file ends where the value of an entry number 1 should follow",
        ),
        (
            ".rsa",
            boeing("RSA 1 1 1 0\n(1I8) (1I8) (1E20.12)\n1\n3\n1\n1.0\n"),
            ":6: the start of a column is 3; starts should rise from 1 to 2",
        ),
        (
            ".rsa",
            boeing("RSA 1 1 99999 0\n(1I8) (1I8) (1E20.12)\n1\n3\n1\n1.0\n"),
            ":3: there should be 99999 entries in 1 columns",
        ),
    ] {
        let message = refusal(ending, text.as_bytes(), None);
        assert!(message.contains(words), "{text}: {message}");
    }
    assert!(
        refusal(".mtx", b"%%MatrixMarket matrix coordinate real general\n\xff\xfe\n", None)
            .contains(":2: this is no text")
    );
}

#[test]
fn entries_that_are_given_twice_are_added_and_said() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("brake.mtx");
    fs::write(&path, "%%MatrixMarket matrix coordinate real general\n2 2 4\n2 2 1.5\n1 2 4\n2 2 1\n1 2 -4\n").unwrap();
    let read = read(&path, None).unwrap();
    assert_eq!(dense(&read), [[0.0, 0.0], [0.0, 2.5]]);
    assert_eq!(read.notes, ["2 entries are given more than once, and added up"]);
}

#[test]
fn cards_of_nastran_go_on_in_further_lines() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("brake.pch");
    let text = "$ two columns of rows, in fields of 8\n\
                DMIG    K2PP           0       1       1       0\n\
                DMIG    K2PP           4       1               4       1  1.5+5         +A      \n\
                +A             4       2 -2.5-1               5       3      7.             \n\
                GRID           4\n\
                               4       2    99.\n\
                DMIG*   K2PP                           5               3                \n\
                *                      4               1        1.25D+02                \n";
    fs::write(&path, text).unwrap();
    let read = read(&path, None).unwrap();
    assert_eq!(read.degrees_of_freedom, Some(vec![(4, 1), (4, 2), (5, 3)]));
    assert_eq!(dense(&read), [[150000.0, 0.0, 125.0], [-0.25, 0.0, 0.0], [7.0, 0.0, 0.0]]);
}

#[test]
fn a_row_without_a_diagonal_in_a_symmetric_file_of_nastran_is_a_doubt() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("brake.pch");
    let read = |columns: &str| {
        fs::write(&path, format!("DMIG,K,0,6,2,0\n{columns}")).unwrap();
        read(&path, None).unwrap()
    };
    let missing = read("DMIG,K,1,1,,1,1,1.0\n,2,1,4.0\nDMIG,K,3,1,,3,1,2.0\n");
    assert!(
        missing.doubts[0].starts_with("line 3: the row of grid point 2 and component 1 has"),
        "{:?}",
        missing.doubts
    );
    // Friction that couples two directions has no diagonal.
    let coupling = read("DMIG,K,1,1,,2,1,4.0\n");
    assert_eq!((dense(&coupling), coupling.doubts.len()), (vec![vec![0.0, 4.0], vec![4.0, 0.0]], 1));
    let given = read("DMIG,K,1,1,,1,1,1.0\n,2,1,4.0\nDMIG,K,2,1,,2,1,0.0\n");
    assert!(given.doubts.is_empty(), "{:?}", given.doubts);
}

#[test]
fn one_side_of_the_diagonal_without_a_diagonal_is_not_mirrored() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("friction.mtx");
    // Friction of a node on a rigid disc: the tangential force follows from the normal distance.
    fs::write(&path, "4,1,4,3,-30000.\n").unwrap();
    let friction = read(&path, None).unwrap();
    assert_eq!((dense(&friction), friction.stored), (vec![vec![0.0, -30000.0], vec![0.0; 2]], Stored::General));
    assert!(friction.doubts[0].contains("above it"), "{:?}", friction.doubts);
    fs::write(&path, "4,1,4,1,2.\n4,1,4,3,-1.\n4,3,4,3,2.\n").unwrap();
    let stiffness = read(&path, None).unwrap();
    assert_eq!(
        (dense(&stiffness), stiffness.stored),
        (vec![vec![2.0, -1.0], vec![-1.0, 2.0]], Stored::SymmetricTriangle)
    );
}

/// An array of NumPy.
fn array(descr: &str, is_by_columns: bool, shape: &str, numbers: &[u8]) -> Vec<u8> {
    let order = if is_by_columns { "True" } else { "False" };
    let header = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
    [&b"\x93NUMPY\x01\x00"[..], &(header.len() as u16).to_le_bytes(), header.as_bytes(), numbers].concat()
}

/// Whole numbers of a byte each.
fn bytes(numbers: &[u8]) -> Vec<u8> {
    array("|u1", false, &format!("({},)", numbers.len()), numbers)
}

/// A zip archive of these members, deflated.
fn archive(members: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let (mut archive, mut list) = (Vec::new(), Vec::new());
    for (name, content) in members {
        let mut packed = DeflateEncoder::new(Vec::new(), Compression::best());
        packed.write_all(content).unwrap();
        let packed = packed.finish().unwrap();
        let mut crc = Crc::new();
        crc.update(content);
        let place = archive.len() as u32;
        // What both records of a member have: version, flags, method, time, date, checksum, sizes, lengths of names.
        let mut record = [20_u16, 0, 8, 0, 0].map(u16::to_le_bytes).concat();
        record.extend([crc.sum(), packed.len() as u32, content.len() as u32].map(u32::to_le_bytes).concat());
        record.extend([name.len() as u16, 0].map(u16::to_le_bytes).concat());
        archive.extend([&b"PK\x03\x04"[..], &record, name.as_bytes(), &packed].concat());
        list.extend([&b"PK\x01\x02\x14\x00"[..], &record, &[0; 10], &place.to_le_bytes(), name.as_bytes()].concat());
    }
    let sizes = [list.len() as u32, archive.len() as u32].map(u32::to_le_bytes).concat();
    [&archive[..], &list, b"PK\x05\x06", &[0; 8], &sizes, &[0; 2]].concat()
}

/// A sparse matrix of SciPy with three rows.
fn sparse(format: &str, arrays: &[(&'static str, Vec<u8>)]) -> Vec<u8> {
    let head = [("format.npy", array("|S3", false, "()", format.as_bytes())), ("shape.npy", bytes(&[3, 3]))];
    archive(&[&head[..], arrays].concat())
}

#[test]
fn diagonals_and_blocks_are_read_in_either_order() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.npz");
    let data =
        |is_by_columns: bool, shape: &str, numbers: &[u8]| ("data.npy", array("|u1", is_by_columns, shape, numbers));
    for (is_by_columns, of_diagonals, of_blocks) in
        [(false, [1, 2, 3, 9, 4, 5], [1, 2, 3, 4, 5, 6]), (true, [1, 9, 2, 4, 3, 5], [1, 4, 2, 5, 3, 6])]
    {
        let diagonals = [("offsets.npy", bytes(&[0, 1])), data(is_by_columns, "(2, 3)", &of_diagonals)];
        fs::write(&path, sparse("dia", &diagonals)).unwrap();
        let expected = vec![vec![1.0, 4.0, 0.0], vec![0.0, 2.0, 5.0], vec![0.0, 0.0, 3.0]];
        assert_eq!(dense(&read(&path, None).unwrap()), expected, "{is_by_columns}");
        let blocks = [
            ("indptr.npy", bytes(&[0, 2])),
            ("indices.npy", bytes(&[0, 2])),
            data(is_by_columns, "(2, 3, 1)", &of_blocks),
        ];
        fs::write(&path, sparse("bsr", &blocks)).unwrap();
        let expected = vec![vec![1.0, 0.0, 4.0], vec![2.0, 0.0, 5.0], vec![3.0, 0.0, 6.0]];
        assert_eq!(dense(&read(&path, None).unwrap()), expected, "{is_by_columns}");
    }
}

#[test]
fn what_a_small_archive_inflates_to_is_bounded() {
    let many = vec![0_u8; 2_000_000];
    let rows = bytes(&[0, 1, 1, 1]);
    let one = bytes(&[1]);
    let ones = vec![1_u8; 1500 * 1500];
    for (content, words) in [
        (
            sparse("csr", &[("indptr.npy", rows.clone()), ("indices.npy", bytes(&many)), ("data.npy", one.clone())]),
            "array `indices`: it has 2000000 numbers, but should have 1048585 at most",
        ),
        (
            sparse("csc", &[("indptr.npy", rows), ("indices.npy", one.clone()), ("data.npy", bytes(&many))]),
            "array `data`: it has 2000000 numbers, but should have 1048585 at most",
        ),
        (
            sparse("csc", &[("indptr.npy", bytes(&many)), ("indices.npy", one.clone()), ("data.npy", one.clone())]),
            "array `indptr`: it has 2000000 numbers, but should have 4 at most; the file is damaged",
        ),
        (
            sparse("coo", &[("row.npy", bytes(&many)), ("col.npy", bytes(&many)), ("data.npy", bytes(&many))]),
            "array `row`: it has 2000000 numbers",
        ),
        (
            sparse("dia", &[("offsets.npy", bytes(&many)), ("data.npy", one)]),
            "array `offsets`: it has 2000000 numbers, but should have 6 at most; the file is damaged",
        ),
        (
            archive(&[("K.npy", array("|b1", false, "(1500, 1500)", &ones))]),
            "entries, the limit for its rows and the length of its compressed file",
        ),
        (archive(&[("K.npy", array("|b1", false, "(2, 2)", &ones))]), "matrix `K`: 2249996 bytes follow the array"),
    ] {
        assert!(content.len() < 20_000, "{}", content.len());
        let message = refusal(".npz", &content, None);
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn what_a_compressed_variable_inflates_to_is_bounded() {
    /// An element of a MAT file: type, length, content, and what fills it up to eight bytes.
    fn element(kind: u32, content: &[u8]) -> Vec<u8> {
        let tag = [kind, content.len() as u32].map(u32::to_le_bytes).concat();
        let filling = vec![0; content.len().next_multiple_of(8) - content.len()];
        [tag, content.to_vec(), filling].concat()
    }
    let words = |numbers: &[u32]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let many = vec![0_u8; 2_000_000];
    // A sparse array (5) of two rows and columns, with room for that many entries.
    let parts = [
        element(6, &words(&[5, 2_000_000])),
        element(5, &words(&[2, 2])),
        element(1, b"K"),
        element(2, &many),
        element(6, &words(&[0, 1_000_000, 2_000_000])),
        element(2, &many),
    ];
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::best());
    packed.write_all(&element(14, &parts.concat())).unwrap();
    let packed = packed.finish().unwrap();
    let head = [&[b' '; 124][..], &[0, 1], b"IM", &words(&[15, packed.len() as u32])].concat();
    let message = refusal(".mat", &[head, packed].concat(), Some("K"));
    assert!(message.contains("`K`: the matrix has more than 1048580 entries, the limit for its rows"), "{message}");
}

#[test]
fn coordinates_may_stand_by_rows_or_by_columns() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("brake.npz");
    for (is_by_columns, coordinates) in [(false, [0, 1, 2, 1, 2, 0]), (true, [0, 1, 1, 2, 2, 0])] {
        let coordinates = array("|u1", is_by_columns, "(2, 3)", &coordinates);
        fs::write(&path, sparse("coo", &[("coords.npy", coordinates), ("data.npy", bytes(&[5, 6, 7]))])).unwrap();
        assert_eq!(dense(&read(&path, None).unwrap()), [[0.0, 5.0, 0.0], [0.0, 0.0, 6.0], [7.0, 0.0, 0.0]]);
    }
    let flat = sparse("coo", &[("coords.npy", bytes(&[0, 1])), ("data.npy", bytes(&[5]))]);
    assert!(refusal(".npz", &flat, None).contains("`coords` has the shape [2], not the two rows"));
}

#[test]
fn the_last_of_several_members_of_a_name_counts() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("brake.npz");
    let of = |value: u8| array("|u1", false, "(1, 1)", &[value]);
    fs::write(&path, archive(&[("K.npy", of(1)), ("M.npy", of(3)), ("K.npy", of(2))])).unwrap();
    assert_eq!(names(&path).unwrap(), ["M", "K"]);
    assert_eq!(dense(&read(&path, Some("K")).unwrap()), [[2.0]]);
}

//! Binary files of finite-element programs: what to export instead.

/// What is said of a file of no known format.
pub const UNKNOWN: &str = "this is no format of matrices that is read; these are: MAT files of version 5 to 7, Matrix Market, .npz and .npy of NumPy and SciPy, .mtx of Abaqus, DMIG of Nastran and OptiStruct (.pch), Harwell-Boeing of Ansys (HBMAT), .sti and .mas of CalculiX";

/// Why a file cannot be read, with the remedy, if its ending or its bytes say that it is binary.
pub fn refusal(head: &[u8], extension: &str) -> Option<String> {
    let (program, remedy) = match extension {
        "full" | "emat" | "esav" | "rst" | "sub" => (
            "Ansys",
            "write the matrices as text in /AUX2: `FILE,job,full` and `HBMAT,stiffness,matrix,,ASCII,STIFF,NO,YES`, and the same with MASS and DAMP",
        ),
        "sim" | "odb" | "fil" => (
            "Abaqus",
            "add a step with `*MATRIX GENERATE, STIFFNESS, MASS, VISCOUS DAMPING` and `*MATRIX OUTPUT, STIFFNESS, MASS, VISCOUS DAMPING, FORMAT=MATRIX INPUT`, which writes .mtx files",
        ),
        "op2" | "op4" | "h3d" => {
            ("Nastran or OptiStruct", "add `PARAM,EXTOUT,DMIGPCH`, which writes the matrices as DMIG to a .pch file")
        }
        _ if head.contains(&0) => return Some(format!("the file is binary, and {UNKNOWN}")),
        _ => return None,
    };
    Some(format!("this is a binary file of {program}, which is not read; {remedy}"))
}
